#include "common/object_model/log_odds.h"

#include <gtest/gtest.h>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/object_model/model_file.h"
#include "common/object_model/object_model.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model {
namespace {

using namespace testing;

CarvingSettings in_mode(CarvingMode mode) {
  CarvingSettings s;
  s.mode = mode;
  return s;
}

// A wall across the optical axis, 1.005 m away: the middle of voxel 10 of 20.
struct ProbableWall {
  voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({1, 0, 0}, Eigen::Matrix3d::Identity()), {0.2, 0.2, 0.2}, 0.01);
  DepthMap map;
  PixelLimits limits;
  LogOdds log_odds{g};
  CarvingSettings settings = in_mode(CarvingMode::probabilistic);
  static constexpr double kFocalBaseline = 156;

  explicit ProbableWall(PixelKind kind = PixelKind::surface) {
    map.camera = Pinhole::from_vertical_fov(300, 300, 0.3);
    map.X_WC = look_along({0, 0, 0}, 0, 0);
    map.depth = map.depth_minimum = ImageF(300, 300, 1, 1.005f);
    limits.limit = map.depth;
    limits.kind = Image<PixelKind>(300, 300, 1, kind);
  }
  void look(double pose_sigma = 0) { log_odds.integrate(map, limits, kFocalBaseline, {.pose_sigma_m = pose_sigma}, settings); }
  double at(int x) const { return log_odds.at({x, 10, 10}); }
};

// Through the formula of log_odds.h by hand: sigma_z = 0.5 px z^2 / (f B) = 3.24 mm, 2 sigma = 6.47 mm; margin 8.7 mm.
TEST(LogOdds, FollowTheDistanceFromTheSurface) {
  ProbableWall s;
  s.look();
  EXPECT_NEAR(s.at(10), 0.85, 2e-3);
  EXPECT_NEAR(s.at(11), 0.85 * (1 - 1.3 / 6.475), 5e-3);                             // 10 mm behind
  EXPECT_NEAR(s.at(9), 0.85 * (1 - 1.3 / 6.475) - 0.4 * (1.3 / 6.475), 5e-3);        // 10 mm before
  EXPECT_NEAR(s.at(7), -0.4, 2e-3);
  EXPECT_NEAR(s.at(12), 0, 1e-3);
  EXPECT_NEAR(s.at(15), 0, 1e-9);
  s.look();
  EXPECT_NEAR(s.at(10), 1.7, 2e-3);
  for (int n = 0; n < 10; ++n) s.look();
  EXPECT_NEAR(s.at(10), 3.5, 1e-9);
  EXPECT_NEAR(s.at(7), -2, 1e-9);
}

TEST(LogOdds, AnUncertainPoseBlursThem) {
  ProbableWall s;
  s.look(0.005);
  EXPECT_NEAR(s.at(10), 0.85, 2e-3);
  EXPECT_GT(s.at(12), 0.03);
  EXPECT_GT(s.at(8), -0.4 + 0.05);
}

TEST(LogOdds, KnownSolidsAreFreeToTheirSurfaceAndHitNothing) {
  ProbableWall s(PixelKind::known_solid);
  for (float& limit : s.limits.limit.data) limit += 0.015f;  // as pixel_limits() has it
  s.look();
  EXPECT_NEAR(s.at(7), -0.4, 2e-3);
  EXPECT_LT(s.at(9), -0.1);
  EXPECT_LE(s.at(10), 0);
  EXPECT_NEAR(s.at(13), 0, 1e-3);
  ProbableWall none(PixelKind::none);
  none.look();
  EXPECT_EQ(none.log_odds.bricks().held(), 0u);
}

// What may be the floor's or stand on it hits nothing either; what is before it is free as before any surface.
TEST(LogOdds, WhatMayStandOnTheFloorIsNotMissed) {
  ProbableWall s(PixelKind::known_solid);
  s.look();
  EXPECT_NEAR(s.at(7), -0.4, 2e-3);
  EXPECT_NEAR(s.at(9), -0.4 * (1.3 / 6.475), 5e-3);
  for (int x = 10; x < 20; ++x) EXPECT_EQ(s.at(x), 0) << x;
}

TEST(LogOdds, EveryInstructionSetGivesTheSameValues) {
  const Sphere sphere;
  const ObjectBox box = box_around(sphere);
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(box.X_WB, box.size, 0.01);
  const DepthMap map = ideal_view(sphere, 1, 6).depth[0];
  const PixelLimits limits{map.depth, Image<PixelKind>(map.depth.width, map.depth.height, 1, PixelKind::surface)};
  LogOdds portable(g);
  portable.integrate(map, limits, 156, {.pose_sigma_m = 0.001}, {}, voxel::Simd::portable);
  EXPECT_GT(portable.bricks().held(), 50u);
  for (const voxel::Simd simd : {voxel::Simd::avx2, voxel::Simd::avx512}) {
    if (!voxel::has_simd(simd)) continue;
    LogOdds other(g);
    other.integrate(map, limits, 156, {.pose_sigma_m = 0.001}, {}, simd);
    EXPECT_TRUE(other == portable);
  }
}

TEST(LogOdds, LabelsFollowThemAndMayComeBack) {
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, 0.01);  // 10 a side: bits beyond the size
  const CarvingSettings settings = in_mode(CarvingMode::probabilistic);
  LogOdds log_odds(g);
  Evidence evidence(g);
  voxel::OccupancyGrid grid(g);
  std::vector<std::uint64_t> environment(grid.occupied().size(), 0);
  environment[grid.word({0, 0, 0})] = voxel::OccupancyGrid::bit({0, 0, 0});
  const auto set = [&](const Eigen::Vector3i& v, double value) {
    log_odds.bricks().hold(voxel::brick_of(g, v))[static_cast<std::size_t>(voxel::within_brick(v))] = static_cast<std::int16_t>(value * 1024);
  };
  set({0, 0, 0}, -2);
  set({1, 0, 0}, -0.7);
  set({2, 0, 0}, -0.5);
  set({3, 0, 0}, 0.3);
  set({4, 0, 0}, 0.5);
  set({5, 0, 0}, 0.1);
  set({6, 0, 0}, 0.5);  // behind what was seen
  set({7, 0, 0}, 0.5);
  set({9, 9, 9}, -1);
  for (const int x : {1, 3, 4}) evidence.set({x, 0, 0}, {3, 0, 0, 0});
  evidence.set({5, 0, 0}, {0, 0, 100, 0});
  evidence.set({7, 0, 0}, {0, 10, 0, 0});
  const auto state = [&](int x) { return grid.state({x, 0, 0}); };
  log_odds.label(environment, settings, evidence, grid);
  EXPECT_EQ(state(0), voxel::VoxelState::environment);
  EXPECT_EQ(state(1), voxel::VoxelState::empty);
  EXPECT_EQ(state(2), voxel::VoxelState::unknown);
  EXPECT_EQ(state(3), voxel::VoxelState::unknown);
  EXPECT_EQ(state(4), voxel::VoxelState::known);
  EXPECT_EQ(state(5), voxel::VoxelState::environment);
  EXPECT_EQ(state(6), voxel::VoxelState::unknown);
  EXPECT_EQ(state(7), voxel::VoxelState::known);
  EXPECT_EQ(grid.counts(), (voxel::Counts{1000 - 6, 2, 2, 2}));
  set({1, 0, 0}, 0.5);
  log_odds.label(environment, settings, evidence, grid);
  EXPECT_EQ(state(1), voxel::VoxelState::known);
  EXPECT_EQ(grid.counts(), (voxel::Counts{1000 - 6, 3, 1, 2}));
}

TEST(WithoutOutliers, DropsWhatStandsAlone) {
  DepthMap map;
  map.depth = map.depth_minimum = ImageF(40, 30, 1, 1.0f);
  Random random(4);
  int wrong = 0;
  for (float& z : map.depth.data) {
    if (random.uniform() < 0.2) {
      z = static_cast<float>(random.uniform(0.5, 3));
      wrong += std::abs(z - 1) > 0.01f;
    }
  }
  for (int y = 0; y < 30; ++y) {
    for (int x = 30; x < 40; ++x) map.depth.at(x, y) = x < 35 ? 2.0f : 0.0f;  // another surface, and nothing beside it
  }
  const DepthMap clean = without_outliers(map, 0.25, 0.01);
  int stray = 0, kept = 0;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) {
      const float z = clean.depth.at(x, y);
      if (z == 0) continue;
      EXPECT_EQ(z, map.depth.at(x, y));
      ++kept;
      stray += std::abs(z - (x < 30 ? 1.0f : 2.0f)) > 0.01f;
    }
  EXPECT_EQ(stray, 0);
  EXPECT_GT(kept, 35 * 30 - wrong - 60);
  EXPECT_EQ(clean.depth_minimum.at(37, 10), 0.0f);
}

struct Damage {
  double known = 0;    // share of the touched voxels that are known
  double emptied = 0;  // share of those that are empty
  double ghosts = 0;   // share of the voxels more than 3 cm outside that are not empty
};
// Six views of a sphere, spoiled by `spoil`, against the voxels that an unspoiled run sees.
template <class Spoil>
Damage carve(CarvingMode mode, Spoil&& spoil) {
  const Sphere sphere;
  ObjectModel model("ball", box_around(sphere), 0.01, {});
  for (int n = 0; n < 6; ++n) {
    Perception p = ideal_view(sphere, n, 6, 320, 240);
    spoil(n, p);
    model.integrate(p, {}, in_mode(mode));
  }
  Damage d;
  int touched = 0, outside = 0;
  for_each_voxel(model.grid().geometry(), [&](const Eigen::Vector3i& v) {
    if (distance_range(model.grid().geometry(), v, sphere).first > sphere.radius + 0.03) {
      ++outside;
      d.ghosts += model.grid().state(v) != voxel::VoxelState::empty;
    }
    if (!touches(model.grid().geometry(), v, sphere)) return;
    ++touched;
    d.known += model.grid().state(v) == voxel::VoxelState::known;
    d.emptied += model.grid().state(v) == voxel::VoxelState::empty;
  });
  d.known /= touched;
  d.emptied /= touched;
  d.ghosts /= outside;
  return d;
}

TEST(LogOdds, WrongDepthsAreOutvoted) {
  const auto wrong = [](int n, Perception& p) {
    Random random(static_cast<std::uint64_t>(n));
    for (DepthMap& map : p.depth) {
      for (std::size_t i = 0; i < map.depth.data.size(); ++i) {
        if (random.uniform() < 0.2) map.depth.data[i] = map.depth_minimum.data[i] = static_cast<float>(1 / random.uniform(1 / 6.0, 1 / 0.6));
      }
    }
  };
  const auto right = [](int, Perception&) {};
  const Damage clean = carve(CarvingMode::probabilistic, right), spoiled = carve(CarvingMode::probabilistic, wrong);
  EXPECT_GT(clean.known, 0.8);  // some show themselves to no view
  EXPECT_LT(clean.emptied, 0.04);  // only a corner of them is the sphere's
  EXPECT_GT(spoiled.known, 0.95 * clean.known);
  EXPECT_LT(spoiled.emptied, 0.04);
  EXPECT_LT(spoiled.ghosts, clean.ghosts + 0.01);
  EXPECT_GT(carve(CarvingMode::conservative, wrong).ghosts, 5 * spoiled.ghosts);
}

TEST(LogOdds, AWrongPoseIsOutvoted) {
  const auto wrong = [](int n, Perception& p) {
    if (n != 2) return;
    const Eigen::Translation3d off(Eigen::Vector3d(0.02, 0, 0));
    p.X_WC = p.X_WC * off;
    for (DepthMap& map : p.depth) map.X_WC = map.X_WC * off;
  };
  const Damage spoiled = carve(CarvingMode::probabilistic, wrong), clean = carve(CarvingMode::probabilistic, [](int, Perception&) {});
  EXPECT_LT(spoiled.emptied, clean.emptied + 0.01);
  EXPECT_GT(spoiled.known, 0.95 * clean.known);
  EXPECT_GT(carve(CarvingMode::conservative, wrong).emptied, 0.1);
}

TEST(LogOdds, AnObjectKeepsTheModeThatItWasBegunIn) {
  const Sphere sphere;
  ObjectModel model("ball", box_around(sphere), 0.025, {});
  model.integrate(ideal_view(sphere, 0, 6, 80, 60), {}, in_mode(CarvingMode::probabilistic));
  ObjectModel expected = model, conservative("ball", box_around(sphere), 0.025, {});
  EXPECT_FALSE(conservative.state().mode.has_value());
  model.integrate(ideal_view(sphere, 1, 6, 80, 60), {}, in_mode(CarvingMode::conservative));
  expected.integrate(ideal_view(sphere, 1, 6, 80, 60), {}, in_mode(CarvingMode::probabilistic));
  for (const int n : {0, 1}) conservative.integrate(ideal_view(sphere, n, 6, 80, 60), {}, in_mode(CarvingMode::conservative));
  EXPECT_EQ(model.digest(), expected.digest());
  EXPECT_TRUE(model.state().log_odds == expected.state().log_odds);
  EXPECT_NE(model.digest(), conservative.digest());
  for (const ObjectModel& again : {model.revised({}, {}, {}, in_mode(CarvingMode::conservative)), read_model(write_model(model))}) {
    EXPECT_EQ(again.state().mode, CarvingMode::probabilistic);
    EXPECT_EQ(again.digest(), model.digest());
    EXPECT_TRUE(again.state().log_odds == model.state().log_odds);
  }
}

}  // namespace
}  // namespace periplus::object_model
