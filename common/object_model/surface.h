// The coloured triangle surface of a signed distance field: naive surface nets (Gibson 1998). One vertex in each cell of
// eight neighbouring samples, at the mean of the zero crossings on its edges; one quad around each crossing edge.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/object_model/tsdf.h"

namespace periplus::object_model {

struct SurfaceMesh {
  std::vector<Eigen::Vector3f> vertices;                  // world [m]
  std::vector<std::array<std::uint8_t, 3>> colors;        // rgb, one a vertex
  std::vector<std::array<std::uint32_t, 3>> triangles;    // counter-clockwise seen from outside
};

// Only next to known voxels of the grid. Edges over which the distance jumps by more than 0.98 of the truncation are where
// one surface hides another, and carry no surface.
SurfaceMesh extract_surface(const voxel::OccupancyGrid& grid, const Tsdf& tsdf, double truncation);

}  // namespace periplus::object_model
