// Thesis 4.2.1.4, Algorithm 3, to the letter and in double precision: what the fast method is held against.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::object_model::testing {

// Each pixel of the rectangle around the projection of voxel `v` must carry a limit beyond the voxel's centre by more than `margin` voxels.
inline bool naive_empty(const voxel::GridGeometry& g, const Eigen::Vector3i& v, const Pinhole& camera, const Pose& X_WC, const ImageF& limit, double margin) {
  const Pose X_CG = X_WC.inverse() * g.X_WG;
  double u0 = 1e9, u1 = -1e9, v0 = 1e9, v1 = -1e9;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d p = X_CG * ((v.cast<double>() + Eigen::Vector3d(c & 1, (c >> 1) & 1, c >> 2)) * g.voxel_size);
    if (p.z() <= 1e-3) return false;
    const Eigen::Vector2d q = camera.project(p);
    u0 = std::min(u0, q.x());
    u1 = std::max(u1, q.x());
    v0 = std::min(v0, q.y());
    v1 = std::max(v1, q.y());
  }
  if (u0 < -0.5 || v0 < -0.5 || u1 >= camera.width - 0.5 || v1 >= camera.height - 0.5) return false;
  const double depth = (X_CG * ((v.cast<double>().array() + 0.5) * g.voxel_size).matrix()).z();
  for (int y = static_cast<int>(std::floor(v0 + 0.5)); y <= static_cast<int>(std::floor(v1 + 0.5)); ++y)
    for (int x = static_cast<int>(std::floor(u0 + 0.5)); x <= static_cast<int>(std::floor(u1 + 0.5)); ++x)
      if (!(limit.at(x, y) - depth > margin * g.voxel_size)) return false;
  return true;
}

inline bool in_plane(const voxel::OccupancyGrid& grid, const std::vector<std::uint64_t>& plane, const Eigen::Vector3i& v) {
  return (plane[grid.word(v)] & voxel::OccupancyGrid::bit(v)) != 0;
}

}  // namespace periplus::object_model::testing
