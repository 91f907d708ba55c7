#include "services/nbv_planner/panorama_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "common/core/error.h"
#include "services/nbv_planner/testing/situations.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv {
namespace {

using voxel::VoxelState;

SearchSettings small(int evaluations) {
  SearchSettings s;
  s.method = SearchMethod::fast;
  s.fast.positions = 40;
  s.max_evaluations = evaluations;
  return s;
}

Situation uneven() {
  return testing::around_the_origin(25, [](int x, int y, int z) {
    const double r = std::hypot(x - 12, y - 12) + 3 * std::sin(z * 0.7 + x * 0.5);
    return r > 11 ? VoxelState::empty : (x + 2 * y) % 11 < 6 && x > 8 ? VoxelState::unknown : VoxelState::known;
  });
}

TEST(PanoramaSearch, SeesAllThatCanBeSeen) {
  // One face of a block: all 225 voxels of it are seen from a range of places, and no more can be.
  for (const SearchMethod method : {SearchMethod::fast, SearchMethod::thorough}) {
    SearchSettings search;
    search.method = method;
    EXPECT_EQ(plan_view(testing::patch_at_plus_x(), 1, search, {}, {}).evaluation.gain.voxels, 225);
  }
}

TEST(PanoramaSearch, ComesNearTheBestOfManyRandomPoses) {
  const Situation s = uneven();
  const PlannedView v = plan_view(s, 1, {}, {}, {});
  const Evaluator evaluator(s, {}, {});
  Evaluator::Workspace w;
  Random random(12);
  int most = 0;
  for (int i = 0; i < 1500; ++i) {
    const double angle = random.uniform(-1.5, 1.5), distance = random.uniform(0.7, 1.8);
    const Eigen::Vector3d target(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 1.1 + random.uniform(-0.2, 0.2));
    const Pose X = look_at({distance * std::cos(angle), distance * std::sin(angle), random.uniform(1, 1.35)}, target);
    const Evaluation e = evaluator.evaluate(X, w);
    if (e.violation == Violation::none) most = std::max(most, e.gain.voxels);
  }
  EXPECT_GE(v.evaluation.gain.voxels, most);
}

TEST(PanoramaSearch, SameBytesOnEveryInstructionSet) {
  const Situation s = uneven();
  SearchSettings search = small(200);
  search.simd = voxel::Simd::portable;
  const PlannedView expected = plan_view(s, 6, search, {}, {});
  for (const voxel::Simd simd : {voxel::Simd::avx2, voxel::Simd::avx512, voxel::Simd::avx512_popcnt}) {
    if (!voxel::has_simd(simd)) continue;
    search.simd = simd;
    const PlannedView found = plan_view(s, 6, search, {}, {});
    EXPECT_EQ(std::memcmp(found.X_WC.matrix().data(), expected.X_WC.matrix().data(), 16 * sizeof(double)), 0);
    EXPECT_EQ(found.f_e, expected.f_e);
    EXPECT_EQ(found.evaluations, expected.evaluations);
  }
}

TEST(PanoramaSearch, KeepsTheBudget) {
  const Situation s = uneven();
  int last = 0;
  for (int budget : {8, 20, 60, 150, 400}) {
    SearchSettings search = small(budget);
    search.keep_candidates = true;
    const PlannedView v = plan_view(s, 2, search, {}, {});
    EXPECT_LE(v.evaluations, budget);
    EXPECT_GT(v.evaluations, budget / 4);
    EXPECT_EQ(v.evaluation.violation, Violation::none);
    EXPECT_FALSE(v.candidates.empty());
    for (const ViewCandidate& c : v.candidates) {
      if (std::strcmp(c.stage, "exact") != 0) continue;
      EXPECT_LE(v.f_e, c.f_e + 1e-9);  // never worse than what was evaluated
    }
    last = v.evaluation.gain.voxels;
  }
  EXPECT_GT(last, 150);
}

TEST(PanoramaSearch, OneCameraAndRoll) {
  Situation s = testing::patch_at_plus_x();
  s.rig = {Pinhole::from_vertical_fov(640, 480, 45 * std::numbers::pi / 180), 0};
  const PlannedView one = plan_view(s, 1, small(250), {}, {});
  EXPECT_EQ(one.evaluation.gain.voxels, 225);
  s = testing::patch_at_plus_x();
  s.limits.roll_max = 0.2;
  const PlannedView rolled = plan_view(s, 1, small(250), {}, {});
  EXPECT_GE(rolled.evaluation.gain.voxels, 220);
  EXPECT_LE(std::abs(camera_yaw_pitch_roll(rolled.X_WC).z()), 0.2 + 1e-9);
}

TEST(PanoramaSearch, MotionAndReachabilityActOnTheChoice) {
  // Two equal unknown faces; the robot is at one of them, or cannot reach the other.
  Situation s = testing::around_the_origin(15, [](int x, int, int) { return x == 0 || x == 14 ? VoxelState::unknown : VoxelState::known; });
  EvaluationSettings evaluation;
  evaluation.lambda_motion = 1;
  for (double side : {-1.0, 1.0}) {
    s.X_WC_now = look_at({side * 1.2, 0, 1.2}, {0, 0, 1.1});
    EXPECT_GT(side * plan_view(s, 1, small(250), evaluation, {}).X_WC.translation().x(), 0.4);
  }
  struct OneSide : Reachability {
    double of(const Pose& X_WC) const override { return X_WC.translation().x() < 0 ? 1 : 0; }
  };
  s.X_WC_now.reset();
  s.reachability = std::make_shared<OneSide>();
  evaluation = {};
  evaluation.lambda_reach = 1;
  EXPECT_LT(plan_view(s, 1, small(250), evaluation, {}).X_WC.translation().x(), -0.4);
}

TEST(PanoramaSearch, TimeLimitGivesAFeasibleView) {
  SearchSettings search;
  search.time_limit_s = 1e-6;
  const PlannedView v = plan_view(uneven(), 1, search, {}, {});
  EXPECT_TRUE(v.cut_short);
  EXPECT_LT(v.evaluations, 60);
  EXPECT_EQ(v.evaluation.violation, Violation::none);
  EXPECT_GT(v.evaluation.gain.voxels, 0);
}

}  // namespace
}  // namespace periplus::nbv
