#include "services/nbv_planner/line_of_sight.h"

#include <gtest/gtest.h>

#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

// Share of the way from a to b that lies in voxel v: negative if it passes by. Grid coordinates [voxels].
double share_within(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3i& v) {
  double in = 0, out = 1;
  for (int i = 0; i < 3; ++i) {
    const double t0 = (v[i] - a[i]) / (b[i] - a[i]), t1 = (v[i] + 1 - a[i]) / (b[i] - a[i]);
    in = std::max(in, std::min(t0, t1));
    out = std::min(out, std::max(t0, t1));
  }
  return out - in;
}

TEST(LineOfSight, AgreesWithEveryVoxelOfARandomGrid) {
  Random random(11);
  const Situation s = testing::around_the_origin(12, [&](int, int, int) {
    return random.uniform() < 0.05 ? voxel::VoxelState::known : voxel::VoxelState::empty;
  });
  const voxel::GridGeometry& g = s.grid->geometry();
  int seen = 0, hidden = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto draw = [&] { return Eigen::Vector3d(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(0.9, 1.3)); };
    const Eigen::Vector3d a = draw(), b = draw();
    const Pose X_GW = g.X_WG.inverse();
    double most = -1;
    for (int x = 0; x < 12; ++x)
      for (int y = 0; y < 12; ++y)
        for (int z = 0; z < 12; ++z)
          if (s.grid->state({x, y, z}) != voxel::VoxelState::empty)
            most = std::max(most, share_within(X_GW * a / g.voxel_size, X_GW * b / g.voxel_size, {x, y, z}));
    // Where a voxel is only just touched rounding decides.
    if (std::abs(most) > 1e-9) {
      EXPECT_EQ(in_sight(s, a, b), most < 0) << i;
    }
    (most < 0 ? seen : hidden)++;
  }
  EXPECT_GT(seen, 300);
  EXPECT_GT(hidden, 300);
}

TEST(LineOfSight, SolidsHideToo) {
  scene::Scene scene;
  scene.solids.push_back(testing::box({0.5, 0, 1.1}, {0.05, 0.5, 0.5}));
  const Situation s = testing::patch_at_plus_x(scene);
  EXPECT_FALSE(in_sight(s, {1, 0, 1.1}, {0.151, 0, 1.1}));
  EXPECT_TRUE(in_sight(s, {1, 0.8, 1.1}, {0.151, 0, 1.1}));
  EXPECT_FALSE(in_sight(s, {-1, 0.8, 1.1}, {0.151, 0, 1.1}));  // through the block
  EXPECT_TRUE(in_sight(s, {-1, 0.8, 1.1}, {-0.151, 0, 1.1}));
}

}  // namespace
}  // namespace periplus::nbv
