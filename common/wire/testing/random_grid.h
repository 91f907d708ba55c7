// Grids for tests of objects on the wire.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/core/random.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::wire::testing {

inline voxel::GridGeometry geometry(const Eigen::Vector3i& size, double voxel_size = 0.01) {
  voxel::GridGeometry g;
  g.X_WG = make_pose({1, 2, 3}, rotation_from_yaw_pitch_roll(0.3, 0, 0));
  g.voxel_size = voxel_size;
  g.size = size;
  return g;
}

// Of `count` voxels anywhere in the box from `least` to `most` (without).
inline void change(voxel::OccupancyGrid& grid, int count, std::uint64_t seed, const Eigen::Vector3i& least, const Eigen::Vector3i& most) {
  Random random(seed);
  for (int n = 0; n < count; ++n) {
    Eigen::Vector3i v;
    for (int axis = 0; axis < 3; ++axis) v[axis] = least[axis] + static_cast<int>(random.below(static_cast<std::uint64_t>(most[axis] - least[axis])));
    grid.set_state(v, static_cast<voxel::VoxelState>(random.below(4)));
  }
}
inline void change(voxel::OccupancyGrid& grid, int count, std::uint64_t seed) { change(grid, count, seed, {0, 0, 0}, grid.geometry().size); }

inline voxel::OccupancyGrid random_grid(const Eigen::Vector3i& size, std::uint64_t seed, std::uint32_t revision = 1) {
  voxel::OccupancyGrid grid(geometry(size));
  grid.revision = revision;
  change(grid, size.prod() / 4, seed);
  return grid;
}

inline bool same_voxels(const voxel::OccupancyGrid& a, const voxel::OccupancyGrid& b) {
  return a.geometry().size == b.geometry().size && a.geometry().voxel_size == b.geometry().voxel_size &&
         a.geometry().X_WG.isApprox(b.geometry().X_WG, 1e-14) && a.occupied() == b.occupied() && a.known() == b.known() && a.environment() == b.environment();
}

}  // namespace periplus::wire::testing
