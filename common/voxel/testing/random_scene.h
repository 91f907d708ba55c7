// Grids and views for the tests of visibility.
#pragma once

#include <Eigen/Core>

#include "common/core/random.h"
#include "common/geometry/pose.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::voxel::testing {

// A tilted grid of 2 cm voxels of all states, a share `fill` of them occupied.
inline OccupancyGrid random_grid(Random& random, const Eigen::Vector3i& size, double fill) {
  GridGeometry g;
  g.X_WG = make_pose({0.3, -0.2, 0.7}, rotation_from_yaw_pitch_roll(random.uniform(-3, 3), 0.1, -0.2));
  g.voxel_size = 0.02;
  g.size = size;
  OccupancyGrid grid(g);
  for (int x = 0; x < size.x(); ++x) {
    for (int y = 0; y < size.y(); ++y) {
      for (int z = 0; z < size.z(); ++z) {
        const double u = random.uniform();
        grid.set_state({x, y, z}, u > fill          ? VoxelState::empty
                                  : u > fill * 0.4  ? VoxelState::unknown
                                  : u > fill * 0.15 ? VoxelState::known
                                                    : VoxelState::environment);
      }
    }
  }
  return grid;
}

inline Eigen::Vector3d center(const GridGeometry& g) { return g.X_WG * (g.size.cast<double>() * g.voxel_size / 2); }

// Looks at about the grid's middle from `near` to `far` metres away.
inline Pose random_view(Random& random, const GridGeometry& g, double near, double far) {
  Eigen::Vector3d d;
  do {
    d = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  } while (d.norm() > 1 || d.norm() < 0.1);
  const Eigen::Vector3d p = center(g) + d.normalized() * random.uniform(near, far);
  Pose X = look_at(p, center(g) + 0.1 * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
  X.linear() = X.linear() * Eigen::AngleAxisd(random.uniform(-0.5, 0.5), Eigen::Vector3d::UnitZ());
  return X;
}

}  // namespace periplus::voxel::testing
