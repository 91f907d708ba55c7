#include "services/posture_generator/object_obstacle.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace periplus::posture {

namespace {
voxel::OccupancyGrid random_blob() {
  voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(
      make_pose({1, 2, 0.9}, rotation_from_yaw_pitch_roll(0.4, 0, 0)), {0.3, 0.26, 0.4}, 0.02));
  Random random(3);
  Eigen::Vector3i v;
  const Eigen::Vector3i n = grid.geometry().size;
  for (v.x() = 0; v.x() < n.x(); ++v.x()) {
    for (v.y() = 0; v.y() < n.y(); ++v.y()) {
      for (v.z() = 0; v.z() < n.z(); ++v.z()) {
        const double u = random.uniform();
        grid.set_state(v, u < 0.8 ? voxel::VoxelState::empty : u < 0.9 ? voxel::VoxelState::unknown : voxel::VoxelState::known);
      }
    }
  }
  return grid;
}
}  // namespace

TEST(ObjectObstacle, EveryOccupiedVoxelLiesInASphere) {
  const auto grid = random_blob();
  const ObjectObstacle obstacle(grid, 0.04);
  Eigen::Vector3i v;
  const Eigen::Vector3i n = grid.geometry().size;
  for (v.x() = 0; v.x() < n.x(); ++v.x()) {
    for (v.y() = 0; v.y() < n.y(); ++v.y()) {
      for (v.z() = 0; v.z() < n.z(); ++v.z()) {
        if (grid.state(v) == voxel::VoxelState::empty) continue;
        const Eigen::Vector3d p = grid.geometry().center_world(v);
        EXPECT_LT(obstacle.nearest(p, p, 1).distance, obstacle.radius());  // sparse: inner cells are surface as well
      }
    }
  }
}

TEST(ObjectObstacle, DistanceIsTheNearestSpheres) {
  const ObjectObstacle obstacle(random_blob(), 0.02);
  Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d a(random.uniform(0, 2), random.uniform(1, 3), random.uniform(0, 2)), b = a + Eigen::Vector3d(0, 0, 1e-7);
    double least = 0.8;
    for (const Eigen::Vector3d& c : obstacle.centers()) least = std::min(least, (c - a).norm() - obstacle.radius());
    EXPECT_NEAR(obstacle.nearest(a, b, 0.8).distance, least, 1e-6);
  }
}

TEST(ObjectObstacle, EnvironmentAndEmptyDoNotCount) {
  voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, 0.02));
  EXPECT_FALSE(ObjectObstacle(grid, 0.02).empty());
  const Eigen::Vector3i n = grid.geometry().size;
  for (int i = 0; i < n.x(); ++i) {
    for (int j = 0; j < n.y(); ++j) {
      for (int k = 0; k < n.z(); ++k) grid.set_state({i, j, k}, voxel::VoxelState::environment);
    }
  }
  EXPECT_TRUE(ObjectObstacle(grid, 0.02).empty());
  EXPECT_EQ(ObjectObstacle().nearest({0, 0, 0}, {0, 0, 1}, 0.5).distance, 0.5);
}

}  // namespace periplus::posture
