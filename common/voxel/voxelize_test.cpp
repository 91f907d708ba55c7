#include "common/voxel/voxelize.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::voxel {
namespace {

GridGeometry tilted() {
  GridGeometry g;
  g.X_WG = make_pose({0.3, -0.2, 0.7}, rotation_from_yaw_pitch_roll(0.7, 0.1, -0.2));
  g.voxel_size = 0.02;
  g.size = {17, 20, 14};
  return g;
}

// Every voxel that holds a point of the triangle is marked, none that is further from its plane or box than a voxel reaches.
TEST(Voxelize, MarksWhatATriangleTouches) {
  Random random(3);
  int marked = 0;
  for (int i = 0; i < 40; ++i) {
    const GridGeometry g = tilted();
    OccupancyGrid grid(g);
    std::vector<Eigen::Vector3d> p;
    for (int k = 0; k < 3; ++k) p.push_back(Eigen::Vector3d(random.uniform(-5, 25), random.uniform(-5, 25), random.uniform(-5, 20)));
    std::vector<Eigen::Vector3d> p_W;
    for (const auto& q : p) p_W.push_back(g.X_WG * (q * g.voxel_size));
    mark_environment(p_W, {{0, 1, 2}}, grid);
    for (int k = 0; k < 3000; ++k) {
      double a = random.uniform(), b = random.uniform();
      if (a + b > 1) a = 1 - a, b = 1 - b;
      const Eigen::Vector3i v = (p[0] + a * (p[1] - p[0]) + b * (p[2] - p[0])).array().floor().cast<int>();
      if (g.contains(v)) {
        EXPECT_EQ(grid.state(v), VoxelState::environment);
      }
    }
    const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    for (int x = 0; x < g.size.x(); ++x) {
      for (int y = 0; y < g.size.y(); ++y) {
        for (int z = 0; z < g.size.z(); ++z) {
          if (grid.state({x, y, z}) != VoxelState::environment) continue;
          ++marked;
          EXPECT_LE(std::abs(normal.dot(Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) - p[0])), 0.5 * normal.lpNorm<1>() + 1e-6);
        }
      }
    }
  }
  EXPECT_GT(marked, 1000);
}

TEST(Voxelize, RefusesWhatIsNoMesh) {
  OccupancyGrid grid(tilted());
  EXPECT_THROW(mark_environment({{0, 0, std::nan("")}}, {}, grid), Error);
  EXPECT_THROW(mark_environment({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}}, grid), Error);
}

}  // namespace
}  // namespace periplus::voxel
