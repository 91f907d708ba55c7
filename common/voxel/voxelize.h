// Solids and meshes into a grid's environment.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/voxel/occupancy_grid.h"

namespace periplus::voxel {

// Makes environment of every voxel that a triangle touches (closed cubes, separating axes: Akenine-Moeller, 2001). A closed mesh's inside is
// left as it is: its surface hides it. Vertices in the world frame [m]; triangles index them. What lies outside of the grid is left out.
// Throws Error(not_finite) for a vertex that is not finite, Error(bad_input) for an index out of range.
void mark_environment(const std::vector<Eigen::Vector3d>& vertices_W, const std::vector<Eigen::Vector3i>& triangles, OccupancyGrid& grid);

}  // namespace periplus::voxel
