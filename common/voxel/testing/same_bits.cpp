#include "common/voxel/testing/same_bits.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/voxel/testing/random_scene.h"

namespace periplus::voxel::testing {

void expect_same_bits(Simd one, Simd other) {
  if (!has_simd(one) || !has_simd(other)) GTEST_SKIP() << "this processor has no such instructions";
  std::uint64_t seen = 0;
  Random random(7);
  for (int i = 0; i < 40; ++i) {
    const OccupancyGrid grid = random_grid(random, Eigen::Vector3i(9 + random.below(30), 7 + random.below(30), 8 + random.below(30)), i % 2 == 0 ? 0.9 : 0.1);
    std::vector<Eigen::Vector3i> watched;
    for (int k = 0; k < 50; ++k) watched.emplace_back(static_cast<int>(random.below(9)), static_cast<int>(random.below(7)), static_cast<int>(random.below(8)));
    const VisibilityScene scene(grid, {Occluder::sphere(center(grid.geometry()) + Eigen::Vector3d(0, 0, 0.3), 0.2)}, watched);
    const Pinhole camera = Pinhole::from_vertical_fov(201 + random.below(60), 150 + random.below(60), random.uniform(0.2, 1.5));
    const Pose X_WC = random_view(random, grid.geometry(), i % 4 == 0 ? 0.0 : 0.3, 1.5);
    VisibilityWorkspace workspace;
    workspace.simd = one;
    VisibilityResult expected, r;
    scene.evaluate(X_WC, camera, workspace, expected);
    workspace.simd = other;
    scene.evaluate(X_WC, camera, workspace, r);
    seen += r.unknown_pixels;
    const auto same = [](const VoxelList& a, const VoxelList& b) {
      return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) { return x.voxel == y.voxel && x.pixels == y.pixels; });
    };
    EXPECT_TRUE(same(r.unknown, expected.unknown));
    EXPECT_TRUE(same(r.watched, expected.watched));
    EXPECT_EQ(r.unknown_pixels, expected.unknown_pixels);
    EXPECT_EQ(r.known_pixels, expected.known_pixels);
    EXPECT_EQ(r.environment_pixels, expected.environment_pixels);
    EXPECT_EQ(r.occluder_pixels, expected.occluder_pixels);
  }
  EXPECT_GT(seen, 100000u);
}

}  // namespace periplus::voxel::testing
