#include <gtest/gtest.h>

#include <algorithm>

#include "common/core/random.h"
#include "common/render/testing/gl_visibility.h"
#include "common/voxel/testing/carved_object.h"
#include "common/voxel/testing/random_scene.h"

namespace periplus::render {
namespace {

// Two rasterisers that share nothing: the visibility kernel and OpenGL's faces with a depth buffer.
TEST(GlVisibility, KernelCountsWhatOpenGlDraws) {
  const GlContext context("auto", 2);
  std::size_t expected = 0, off = 0;
  std::uint64_t pixels = 0, wrong = 0;
  const auto compare = [&](const voxel::OccupancyGrid& grid, const std::vector<Pose>& views, const Pinhole& camera) {
    GlVisibility gl(context, grid, 640, 480);
    const voxel::VisibilityScene scene(grid);
    for (const Pose& X_WC : views) {
      const auto drawn = gl.evaluate(X_WC, camera);
      const voxel::VisibilityResult r = scene.evaluate(X_WC, camera);
      const auto voxels = static_cast<std::size_t>(std::count_if(r.unknown.begin(), r.unknown.end(), [](const auto& v) { return v.pixels > 5; }));
      EXPECT_NEAR(static_cast<double>(voxels), static_cast<double>(drawn.voxels(5)), std::max(1.0, 0.01 * static_cast<double>(voxels)));
      expected += drawn.voxels(5);
      off += std::max(voxels, drawn.voxels(5)) - std::min(voxels, drawn.voxels(5));
      pixels += r.unknown_pixels + r.known_pixels + r.environment_pixels;
      wrong += voxel::testing::difference(drawn, r);
    }
  };
  const auto object = voxel::testing::carved_object(96, 0.5, 3);
  compare(object.grid, voxel::testing::views_of(object, 0.5, 4, 5), voxel::testing::carved_object_camera());
  Random random(13);
  const voxel::OccupancyGrid noise = voxel::testing::random_grid(random, {50, 40, 45}, 0.1);
  std::vector<Pose> views;
  for (int i = 0; i < 4; ++i) views.push_back(voxel::testing::random_view(random, noise.geometry(), 0.9, 2.0));
  compare(noise, views, Pinhole::from_vertical_fov(640, 480, 0.6));
  EXPECT_GT(expected, 10000u);
  EXPECT_LE(static_cast<double>(off), 0.01 * static_cast<double>(expected));
  EXPECT_LE(static_cast<double>(wrong), 0.01 * static_cast<double>(pixels));
}

}  // namespace
}  // namespace periplus::render
