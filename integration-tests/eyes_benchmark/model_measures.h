// How well a carved model agrees with the true object.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/mesh/triangle_tree.h"
#include "common/object_model/surface.h"
#include "common/voxel/occupancy_grid.h"
#include "integration-tests/eyes_benchmark/stereo_measures.h"
#include "integration-tests/eyes_benchmark/voxel_truth.h"

namespace periplus::eyes_benchmark {

struct ModelQuality {
  double covered_1_5 = 0, covered_1 = 0;  // share of the visible surface with a known voxel's centre within 1.5, 1 voxels
  Spread error;                           // distance of the model's surface from the true one [m]
  std::size_t inside = 0, inside_emptied = 0;      // voxels with their centre in the object
  std::size_t touching = 0, touching_emptied = 0;  // voxels that its surface passes through
  double ghosts = 0;                      // voxels left standing wholly outside, of the object's volume
  double inside_emptied_share() const { return inside == 0 ? 0 : static_cast<double>(inside_emptied) / static_cast<double>(inside); }
  double touching_emptied_share() const { return touching == 0 ? 0 : static_cast<double>(touching_emptied) / static_cast<double>(touching); }
};

// Share of `points` (world) within `reach` [m] of the centre of a known voxel; 0 of none.
double covered_share(const voxel::OccupancyGrid& grid, const std::vector<Eigen::Vector3d>& points, double reach);
// Of the vertices of `surface` above the height `floor` [m] to the true surface.
Spread surface_error(const object_model::SurfaceMesh& surface, const mesh::TriangleTree& truth, double floor);
// The voxel counts alone. Environment is not emptied, and no ghost.
void count_voxels(const voxel::OccupancyGrid& grid, const VoxelTruth& truth, ModelQuality& quality);

}  // namespace periplus::eyes_benchmark
