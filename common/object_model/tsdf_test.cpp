#include "common/object_model/tsdf.h"

#include <gtest/gtest.h>

#include "common/object_model/evidence.h"

namespace periplus::object_model {
namespace {

struct Wall {
  voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({1, 0, 0}, Eigen::Matrix3d::Identity()), {0.2, 0.2, 0.2}, 0.01);
  DepthMap map;
  PixelLimits limits;
  ImageU8 color{200, 200, 3};

  explicit Wall(float depth, PixelKind kind = PixelKind::surface) {
    map.camera = Pinhole::from_vertical_fov(200, 200, 0.3);
    map.X_WC = look_along({0, 0, 0}, 0, 0);
    map.depth = map.depth_minimum = ImageF(200, 200, 1, depth);
    limits.limit = map.depth;
    limits.kind = Image<PixelKind>(200, 200, 1, kind);
    for (std::size_t i = 0; i < color.data.size(); ++i) color.data[i] = static_cast<std::uint8_t>(10 * (i % 3 + 1));
  }
  const TsdfSample& sample(const Tsdf& tsdf, int x) const { return tsdf.samples()[voxel_index(g, {x, 10, 10})]; }
};

TEST(Tsdf, HoldsTruncatedDistancesThatFadeBehindTheSurface) {
  Wall s(1.0f);  // between voxels 9 and 10
  Tsdf tsdf(s.g);
  tsdf.integrate(s.map, s.limits, s.color, s.g, 0.03);
  EXPECT_NEAR(s.sample(tsdf, 9).distance, 0.005, 1e-6);
  EXPECT_NEAR(s.sample(tsdf, 10).distance, -0.005, 1e-6);
  EXPECT_NEAR(s.sample(tsdf, 2).distance, 0.03, 1e-6);
  EXPECT_EQ(s.sample(tsdf, 2).weight, 1);
  EXPECT_NEAR(s.sample(tsdf, 11).weight, 0.5, 1e-5);
  EXPECT_EQ(s.sample(tsdf, 14).weight, 0);
}

TEST(Tsdf, AveragesViewsAndColours) {
  Wall near(0.998f), far(1.002f);
  Tsdf tsdf(near.g);
  tsdf.integrate(near.map, near.limits, near.color, near.g, 0.03);
  tsdf.integrate(far.map, far.limits, {}, near.g, 0.03);
  EXPECT_NEAR(near.sample(tsdf, 9).distance, 0.005, 1e-6);
  EXPECT_EQ(near.sample(tsdf, 9).weight, 2);
  EXPECT_NEAR(near.sample(tsdf, 9).r, 10, 1e-4);
  EXPECT_NEAR(near.sample(tsdf, 9).b, 30, 1e-4);
  EXPECT_EQ(near.sample(tsdf, 9).color_weight, 1);
  EXPECT_EQ(near.sample(tsdf, 2).color_weight, 0);
}

TEST(Tsdf, KnownSolidsAndPixelsWithoutDepthMakeNoSurface) {
  Wall solid(1.0f, PixelKind::known_solid);
  Tsdf tsdf(solid.g);
  tsdf.integrate(solid.map, solid.limits, solid.color, solid.g, 0.03);
  for (const TsdfSample& s : tsdf.samples()) EXPECT_GE(s.distance, 0);
  EXPECT_EQ(solid.sample(tsdf, 9).weight, 0);
  EXPECT_EQ(solid.sample(tsdf, 5).weight, 1);
  Wall none(1.0f, PixelKind::none);
  Tsdf blind(none.g);
  blind.integrate(none.map, none.limits, none.color, none.g, 0.03);
  for (const TsdfSample& s : blind.samples()) EXPECT_EQ(s.weight, 0);
}

}  // namespace
}  // namespace periplus::object_model
