#include "common/object_model/tsdf.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/object_model/testing/dense_tsdf.h"
#include "common/object_model/testing/random_scene.h"
#include "common/object_model/testing/sphere_views.h"

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
  TsdfSample sample(const Tsdf& tsdf, int x) const { return tsdf.at({x, 10, 10}); }
};

TEST(Tsdf, HoldsTruncatedDistancesThatFadeBehindTheSurface) {
  Wall s(1.0f);  // between voxels 9 and 10
  Tsdf tsdf(s.g);
  tsdf.integrate(s.map, s.limits, s.color, 0.03);
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
  tsdf.integrate(near.map, near.limits, near.color, 0.03);
  tsdf.integrate(far.map, far.limits, {}, 0.03);
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
  tsdf.integrate(solid.map, solid.limits, solid.color, 0.03);
  testing::for_each_voxel(solid.g, [&](const Eigen::Vector3i& v) { EXPECT_GE(tsdf.at(v).distance, 0); });
  EXPECT_EQ(solid.sample(tsdf, 9).weight, 0);
  EXPECT_EQ(solid.sample(tsdf, 8).weight, 1);
  EXPECT_EQ(solid.sample(tsdf, 2).weight, 1);
  Wall none(1.0f, PixelKind::none);
  Tsdf blind(none.g);
  blind.integrate(none.map, none.limits, none.color, 0.03);
  EXPECT_EQ(blind.bricks().held(), 0u);
  EXPECT_TRUE(blind == Tsdf(none.g));
}

// Voxel by voxel, over a grid that slanted views cross: the passes over bricks leave nothing out.
TEST(Tsdf, HoldsWhatAPassOverAllVoxelsGives) {
  const testing::Sphere sphere;
  const ObjectBox box = testing::box_around(sphere);
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(box.X_WB, box.size, 0.01);
  constexpr double kTruncation = 0.03;
  Tsdf tsdf(g);
  struct Mean {
    double distance = 0, weight = 0;
    bool doubtful = false;  // either of two pixels will do
  };
  std::vector<Mean> expected(static_cast<std::size_t>(g.size.prod()));
  for (int n = 0; n < 3; ++n) {
    const Perception p = testing::ideal_view(sphere, n, 6);
    const DepthMap& map = p.depth[0];
    PixelLimits limits{map.depth, Image<PixelKind>(map.depth.width, map.depth.height, 1, PixelKind::surface)};
    for (int x = 100; x < 140; ++x) {
      for (int y = 0; y < map.depth.height; ++y) limits.kind.at(x, y) = PixelKind::none;
    }
    tsdf.integrate(map, limits, {}, kTruncation);
    const Pose X_CG = map.X_WC.inverse() * g.X_WG;
    testing::for_each_voxel(g, [&](const Eigen::Vector3i& v) {
      const Eigen::Vector3d c = X_CG * ((v.cast<double>().array() + 0.5) * g.voxel_size).matrix();
      const Eigen::Vector2d q = map.camera.project(c), off = (q.array() + 0.5) - (q.array() + 0.5).floor();
      Mean& mean = expected[voxel::voxel_index(g, v)];
      mean.doubtful |= off.minCoeff() < 1e-3 || off.maxCoeff() > 1 - 1e-3;
      if (q.x() <= -0.5 || q.y() <= -0.5 || q.x() >= map.depth.width - 0.5 || q.y() >= map.depth.height - 0.5) return;
      const int x = static_cast<int>(q.x() + 0.5), y = static_cast<int>(q.y() + 0.5);
      const double s = map.depth.at(x, y) - c.z();
      if (limits.kind.at(x, y) == PixelKind::none || s <= -kTruncation) return;
      const double weight = s < 0 ? 1 + s / kTruncation : 1;
      mean.distance = (mean.distance * mean.weight + weight * std::min(s, kTruncation)) / (mean.weight + weight);
      mean.weight += weight;
    });
  }
  int seen = 0;
  testing::for_each_voxel(g, [&](const Eigen::Vector3i& v) {
    const Mean& mean = expected[voxel::voxel_index(g, v)];
    if (mean.doubtful) return;
    seen += mean.weight > 0;
    ASSERT_NEAR(tsdf.at(v).weight, mean.weight, 2e-3) << v.transpose();
    if (mean.weight > 0.01) {
      ASSERT_NEAR(tsdf.at(v).distance, mean.distance, 1e-4) << v.transpose();
    }
  });
  EXPECT_GT(seen, 50000);
  EXPECT_LT(tsdf.bricks().held(), voxel::brick_count(g));
}

// Bricks that are free as a whole, in part, or hold a surface: whichever way they are kept, the samples are those of a field that keeps all.
TEST(Tsdf, HoldsTheBitsOfADenseFieldOverRandomScenes) {
  std::size_t seen = 0, held = 0, bricks = 0;
  for (int number = 0; number < testing::scene_count(); ++number) {
    const testing::RandomScene s(number);
    const voxel::GridGeometry& g = s.geometry();
    Tsdf tsdf(g);
    testing::DenseTsdf dense(g);
    Random random(static_cast<std::uint64_t>(number));
    for (std::size_t n = 0; n < s.maps.size(); ++n) {
      const DepthMap& map = s.maps[n];
      PixelLimits limits{map.depth, Image<PixelKind>(map.depth.width, map.depth.height, 1, PixelKind::surface)};
      // A block of pixels that say nothing, and one of a known solid's.
      for (const PixelKind kind : {PixelKind::none, PixelKind::known_solid}) {
        const auto left = static_cast<int>(random.below(120)), top = static_cast<int>(random.below(80));
        for (int y = top; y < top + 30; ++y) {
          for (int x = left; x < left + 30; ++x) limits.kind.at(x, y) = kind;
        }
      }
      ImageU8 color;
      if (n % 2 == 0) {
        color = ImageU8(map.depth.width, map.depth.height, 3);
        for (std::uint8_t& c : color.data) c = static_cast<std::uint8_t>(random.below(256));
      }
      // The settings may change between views.
      const double truncation = (n < 6 ? 3 : 1) * g.voxel_size;
      tsdf.integrate(map, limits, color, truncation);
      dense.integrate(map, limits, color, truncation);
    }
    testing::for_each_voxel(g, [&](const Eigen::Vector3i& v) {
      ASSERT_EQ(tsdf.at(v), dense.at(v)) << "scene " << number << ", voxel " << v.transpose();
      seen += dense.at(v).weight > 0;
    });
    held += tsdf.bricks().held();
    bricks += voxel::brick_count(g);
  }
  EXPECT_GT(seen, 10000u * static_cast<std::size_t>(testing::scene_count()));
  EXPECT_GT(held, 0u);
  EXPECT_LT(held, bricks);
}

// What was seen to be free by n depth maps is one sample, whatever n: such bricks take little, however many there are.
TEST(Tsdf, BricksWithoutSurfaceHaveNoMoreSamplesThanDepthMaps) {
  const testing::Sphere sphere;
  const ObjectBox box = testing::box_around(sphere);
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(box.X_WB, box.size, 0.006);
  Tsdf tsdf(g);
  const int maps = 6;
  for (int n = 0; n < maps; ++n) {
    const DepthMap map = testing::ideal_view(sphere, n, maps).depth[0];
    tsdf.integrate(map, {map.depth, Image<PixelKind>(map.depth.width, map.depth.height, 1, PixelKind::surface)}, {}, 0.018);
  }
  int free = 0;
  for (std::size_t b = 0; b < tsdf.bricks().size(); ++b) {
    const PackedTsdfBrick* brick = tsdf.bricks().find(b);
    if (!brick || std::any_of(brick->distinct().begin(), brick->distinct().end(), [](const TsdfSample& s) { return s.weight > 0 && s.distance < 0.0179f; })) continue;
    EXPECT_LE(brick->distinct().size(), 1u + maps);
    ++free;
  }
  EXPECT_GT(free, 200);
}

TEST(Tsdf, EveryInstructionSetGivesTheSameBits) {
  const testing::Sphere sphere;
  const ObjectBox box = testing::box_around(sphere);
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(box.X_WB, box.size, 0.01);
  const Perception p = testing::ideal_view(sphere, 2, 6);
  const PixelLimits limits{p.depth[0].depth, Image<PixelKind>(p.depth[0].depth.width, p.depth[0].depth.height, 1, PixelKind::surface)};
  Tsdf portable(g);
  portable.integrate(p.depth[0], limits, p.color, 0.03, voxel::Simd::portable);
  for (const voxel::Simd simd : {voxel::Simd::avx2, voxel::Simd::avx512}) {
    if (!voxel::has_simd(simd)) continue;
    Tsdf other(g);
    other.integrate(p.depth[0], limits, p.color, 0.03, simd);
    EXPECT_TRUE(other == portable);
  }
}

}  // namespace
}  // namespace periplus::object_model
