// Situations whose answer is known beforehand: one unknown patch that can be seen from a few places only, or from none.
// Whether an answer is right is decided here by rays against every voxel and every solid, not by the planner's own kernel.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "common/core/error.h"
#include "services/nbv_planner/testing/situations.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using voxel::VoxelState;

constexpr double kDeg = std::numbers::pi / 180;

// Where the segment from p to q enters the box, as a share of its length; infinity if it misses.
double entry(const Vector3d& p, const Vector3d& q, const Vector3d& lower, const Vector3d& upper) {
  double in = 0, out = 1;
  for (int a = 0; a < 3; ++a) {
    const double d = q[a] - p[a];
    if (std::abs(d) < 1e-15) {
      if (p[a] < lower[a] || p[a] > upper[a]) return std::numeric_limits<double>::infinity();
      continue;
    }
    const double t0 = (lower[a] - p[a]) / d, t1 = (upper[a] - p[a]) / d;
    in = std::max(in, std::min(t0, t1));
    out = std::min(out, std::max(t0, t1));
  }
  return in <= out ? in : std::numeric_limits<double>::infinity();
}

// Rays from one eye to points all over the free faces of a voxel: whether one reaches it unhindered, within the image and
// the depth range.
bool is_seen(const Situation& s, const Vector3i& target, const Pose& X_WC, const voxel::PairOptions& pair) {
  const voxel::GridGeometry& g = s.grid->geometry();
  const Pose X_CW = X_WC.inverse();
  const Vector3d eye = X_WC.translation(), eye_G = g.X_WG.inverse() * eye;
  const double depth = (X_CW * g.center_world(target)).z();
  if (depth < pair.depth_min || depth > pair.depth_max) return false;
  const auto has_free_face = [&](const Vector3i& v) {
    for (int face = 0; face < 6; ++face)
      if (s.grid->state(v + (face % 2 ? 1 : -1) * Vector3i::Unit(face / 2)) == VoxelState::empty) return true;
    return false;
  };
  std::vector<Vector3i> others;  // what a ray may meet first
  for (int x = 0; x < g.size.x(); ++x)
    for (int y = 0; y < g.size.y(); ++y)
      for (int z = 0; z < g.size.z(); ++z)
        if (s.grid->state({x, y, z}) != VoxelState::empty && Vector3i(x, y, z) != target && has_free_face({x, y, z})) others.emplace_back(x, y, z);
  const auto free = [&](const Vector3d& p_G, const Vector3d& p) {
    for (const Vector3i& v : others)
      if (entry(eye_G, p_G, v.cast<double>() * g.voxel_size, (v.cast<double>().array() + 1) * g.voxel_size) < 1 - 1e-9) return false;
    for (const scene::Solid& solid : s.scene.solids) {
      const Pose X_SW = solid.X_WS.inverse();
      if (entry(X_SW * eye, X_SW * p, -solid.size / 2, solid.size / 2) < 1) return false;
    }
    return true;
  };
  const Vector3d lower = target.cast<double>() * g.voxel_size, upper = lower.array() + g.voxel_size;
  constexpr int kSteps = 16;
  for (int face = 0; face < 6; ++face) {
    if (s.grid->state(target + (face % 2 ? 1 : -1) * Vector3i::Unit(face / 2)) != VoxelState::empty) continue;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps; ++j) {
        Vector3d inside;
        inside[face / 2] = face % 2;
        inside[(face / 2 + 1) % 3] = (i + 0.5) / kSteps;
        inside[(face / 2 + 2) % 3] = (j + 0.5) / kSteps;
        const Vector3d p_G = lower + inside * g.voxel_size, p = g.X_WG * p_G;
        const Eigen::Vector2d px = s.rig.camera.project(X_CW * p);
        const bool in_image = px.minCoeff() >= -0.5 && px.x() < s.rig.camera.width - 0.5 && px.y() < s.rig.camera.height - 0.5;
        if (in_image && entry(eye_G, p_G, lower, upper) > 1 - 1e-9 && free(p_G, p)) return true;
      }
  }
  return false;
}

// Unknown voxels that rays from each eye reach.
int seen_by_both(const Situation& s, const Pose& X_WC) {
  const voxel::GridGeometry& g = s.grid->geometry();
  const Pose X_WR = X_WC * Pose(Eigen::Translation3d(s.rig.baseline, 0, 0));
  int seen = 0;
  for (int x = 0; x < g.size.x(); ++x)
    for (int y = 0; y < g.size.y(); ++y)
      for (int z = 0; z < g.size.z(); ++z)
        if (s.grid->state({x, y, z}) == VoxelState::unknown)
          seen += is_seen(s, {x, y, z}, X_WC, {}) && is_seen(s, {x, y, z}, X_WR, {});
  return seen;
}

PlannedView answer(const Situation& s, std::uint64_t seed) { return plan_view(s, seed, {}, {}, {}); }

// The right view, whatever the seed; and with it forbidden another that is right too.
void expect_right_views(Situation s, int at_least) {
  for (std::uint64_t seed : {1, 2}) {
    s.forbidden.clear();
    for (int asked = 0; asked < 2; ++asked) {
      const PlannedView v = answer(s, seed);
      SCOPED_TRACE("seed " + std::to_string(seed) + ", asked " + std::to_string(asked));
      EXPECT_GE(seen_by_both(s, v.X_WC), at_least) << v.X_WC.translation().transpose() << " ypr " << camera_yaw_pitch_roll(v.X_WC).transpose() / kDeg;
      EXPECT_GE(v.evaluation.gain.voxels, at_least);
      EXPECT_EQ(v.evaluation.violation, Violation::none);
      for (const Pose& F : s.forbidden)
        EXPECT_TRUE((F.translation() - v.X_WC.translation()).norm() > 0.10 || angle_between(F, v.X_WC) > 10 * kDeg);
      s.forbidden.push_back(v.X_WC);
    }
  }
}

void expect_no_reachable_view(const Situation& s, const char* in_message) {
  for (std::uint64_t seed : {1, 2}) {
    try {
      const PlannedView v = answer(s, seed);
      ADD_FAILURE() << "seed " << seed << ": gain " << v.evaluation.gain.voxels << " at " << v.X_WC.translation().transpose();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::nbv_no_reachable_view);
      EXPECT_NE(std::string(e.what()).find(in_message), std::string::npos) << e.what();
    }
  }
}

// A known block of 0.3 m, its middle at 1.1 m, with a patch of 3 x 3 unknown voxels in the middle of its face at +x.
Situation block_with_patch(scene::Scene scene = {}) {
  return testing::around_the_origin(
      15, [](int x, int y, int z) { return x == 14 && std::abs(y - 7) <= 1 && std::abs(z - 7) <= 1 ? VoxelState::unknown : VoxelState::known; },
      std::move(scene));
}

TEST(KnownAnswers, APatchBehindAWallIsSeenPastItsEnd) {
  scene::Scene scene;  // before the patch, too near for the robot to stand between; its right end leaves a way to look past
  scene.solids.push_back(testing::box({0.50, 0.9, 1.0}, {0.05, 2.2, 2.0}));
  const Situation s = block_with_patch(scene);
  expect_right_views(s, 9);
}

TEST(KnownAnswers, APatchBehindAWallWithoutEndIsNotReachable) {
  scene::Scene scene;
  scene.solids.push_back(testing::box({0.35, 0.0, 1.4}, {0.05, 6.0, 2.8}));
  expect_no_reachable_view(block_with_patch(scene), "unknown");
}

// A cup: inner side `bore` voxels, `depth` voxels deep, its bottom inside unknown but for the outermost ring.
Situation cup(int bore, int depth, double top) {
  const int n = bore + 4;
  Situation s = testing::around_the_origin(n, [](int, int, int) { return VoxelState::empty; });
  voxel::GridGeometry g = s.grid->geometry();
  g.size.z() = depth + 2;
  g.X_WG.translation().z() = top - g.size.z() * g.voxel_size;
  auto grid = std::make_shared<voxel::OccupancyGrid>(g);
  grid->revision = 1;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < g.size.z(); ++z) {
        const int from_wall = std::min({x - 2, y - 2, n - 3 - x, n - 3 - y});
        const bool inside = from_wall >= 0;
        grid->set_state({x, y, z}, inside && z >= 2 ? VoxelState::empty
                                   : inside && z == 1 && from_wall >= 1 ? VoxelState::unknown : VoxelState::known);
      }
  s.grid = grid;
  return s;
}

TEST(KnownAnswers, TheBottomOfACupIsSeenFromAbove) {
  expect_right_views(cup(10, 4, 0.9), 15);
}

TEST(KnownAnswers, TheBottomOfADeepCupIsNotReachable) {
  expect_no_reachable_view(cup(6, 16, 1.0), "unknown");
}

TEST(KnownAnswers, ATopAboveTheEyesIsNotReachableAndASideIs) {
  const auto tall = [](bool top) {
    Situation s = testing::around_the_origin(15, [&](int x, int y, int z) {
      const bool patch = top ? z == 14 && std::abs(x - 7) <= 2 && std::abs(y - 7) <= 2 : x == 14 && std::abs(y - 7) <= 1 && z >= 12;
      return patch ? VoxelState::unknown : VoxelState::known;
    });
    auto grid = std::make_shared<voxel::OccupancyGrid>(*s.grid);
    voxel::GridGeometry g = grid->geometry();
    g.X_WG.translation().z() = 1.4;  // its top at 1.7 m; the eyes reach 1.35 m
    auto raised = std::make_shared<voxel::OccupancyGrid>(g);
    raised->adopt(grid->occupied(), grid->known(), grid->environment());
    raised->revision = 1;
    s.grid = raised;
    return s;
  };
  expect_no_reachable_view(tall(true), "unknown");
  expect_right_views(tall(false), 6);
}

// A block of 0.4 m with a slot from its face at +x down to an unknown patch, one voxel wide and 14 deep: along z (upright)
// or along y (lying).
Situation slot(bool upright) {
  Situation s = testing::around_the_origin(20, [&](int x, int y, int z) {
    const int across = upright ? y : z, along = upright ? z : y;
    if (across != 10 || std::abs(along - 10) > 6 || x < 5) return VoxelState::known;
    return x == 5 ? VoxelState::unknown : VoxelState::empty;
  });
  s.limits.distance_max = 0.9;
  return s;
}

TEST(KnownAnswers, APatchThatOnlyOneEyeCanSeeIsNoGainForAPair) {
  // Lying, the slot lets both eyes in; upright it is narrower than the eyes are apart, from wherever they may stand.
  expect_right_views(slot(false), 3);
  Situation upright = slot(true);
  expect_no_reachable_view(upright, "unknown");
  upright.rig.baseline = 0;  // one camera alone looks in
  expect_right_views(upright, 3);
}

TEST(KnownAnswers, APatchAtTheEdgeOfAWideObjectIsBroughtIntoBothImages) {
  // 1.2 m wide, and so near that both images share a third of it: the patch stands at its end.
  Situation s = testing::around_the_origin(15, [](int, int, int) { return VoxelState::empty; });
  voxel::GridGeometry g = s.grid->geometry();
  g.size = {5, 60, 20};
  g.X_WG = make_pose({-0.05, -0.6, 0.9}, Eigen::Matrix3d::Identity());
  auto grid = std::make_shared<voxel::OccupancyGrid>(g);
  for (int x = 0; x < 5; ++x)
    for (int y = 0; y < 60; ++y)
      for (int z = 0; z < 20; ++z) grid->set_state({x, y, z}, x == 4 && y < 3 && std::abs(z - 10) <= 1 ? VoxelState::unknown : VoxelState::known);
  grid->revision = 1;
  s.grid = grid;
  s.limits.distance_max = 0.8;
  expect_right_views(s, 9);
}

TEST(KnownAnswers, ACompleteOrAnEmptyModelGivesAViewWithoutGain) {
  for (VoxelState all : {VoxelState::known, VoxelState::empty, VoxelState::environment}) {
    const PlannedView v = answer(testing::around_the_origin(15, [&](int, int, int) { return all; }), 1);
    EXPECT_EQ(v.evaluation.gain.voxels, 0);
    EXPECT_EQ(v.evaluation.gain.pixels, 0u);
    EXPECT_EQ(v.evaluation.violation, Violation::none);
  }
  // Unknown voxels that known ones enclose are nothing to look for either.
  const PlannedView v = answer(testing::around_the_origin(15, [](int x, int y, int z) {
    return std::max({std::abs(x - 7), std::abs(y - 7), std::abs(z - 7)}) < 4 ? VoxelState::unknown : VoxelState::known;
  }), 1);
  EXPECT_EQ(v.evaluation.gain.voxels, 0);
}

TEST(KnownAnswers, TheCameraNeverStandsInAnObstacle) {
  // A solid stands where the best views would be: the answer is outside it. It fills the room: there is none.
  scene::Scene scene;
  scene.solids.push_back(testing::box({1.25, 0, 1.0}, {1.2, 1.2, 2.0}));
  const Situation s = block_with_patch(scene);
  try {
    const PlannedView v = answer(s, 1);
    EXPECT_FALSE(s.collision->contains(v.X_WC.translation(), 0.149));
    EXPECT_FALSE(s.collision->contains(v.X_WC * Vector3d(s.rig.baseline, 0, 0), 0.149));
    EXPECT_GT(seen_by_both(s, v.X_WC), 0);
  } catch (const Error& e) {
    ADD_FAILURE() << e.what();
  }
  scene::Scene full;
  full.solids.push_back(testing::box({0, 0, 1.4}, {6, 6, 2.8}));
  expect_no_reachable_view(block_with_patch(full), "obstacles");
}

TEST(KnownAnswers, WhereTheCameraIsNowDoesNotMatterUnlessItsMotionCosts) {
  scene::Scene scene;
  scene.solids.push_back(testing::box({2, 2, 0.5}, {0.5, 0.5, 1.0}));
  Situation s = block_with_patch(scene);
  const Pose free = answer(s, 1).X_WC;
  s.X_WC_now = look_along({2, 2, 0.5}, 0, 0);  // in an obstacle
  EXPECT_EQ(answer(s, 1).X_WC.matrix(), free.matrix());
}

TEST(KnownAnswers, WhatIsNoNumberIsRefused) {
  const auto code = [](const std::function<void(Situation&)>& spoil) {
    Situation s = block_with_patch();
    spoil(s);
    try {
      answer(s, 1);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  };
  static constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code([](Situation& s) { s.limits.height_min = kNoNumber; }), ErrorCode::not_finite);
  EXPECT_EQ(code([](Situation& s) { s.limits.distance_max = std::numeric_limits<double>::infinity(); }), ErrorCode::not_finite);
  EXPECT_EQ(code([](Situation& s) { s.forbidden.push_back(Pose(Eigen::Translation3d(kNoNumber, 0, 1))); }), ErrorCode::not_finite);
  EXPECT_EQ(code([](Situation& s) { s.rig.camera.fx = kNoNumber; }), ErrorCode::bad_input);
  EXPECT_EQ(code([](Situation& s) { s.rig.baseline = kNoNumber; }), ErrorCode::bad_input);
  EXPECT_EQ(code([](Situation& s) { s.grid = nullptr; }), ErrorCode::bad_input);
}

}  // namespace
}  // namespace periplus::nbv
