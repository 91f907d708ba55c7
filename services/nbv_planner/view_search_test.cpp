#include "services/nbv_planner/view_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "common/core/error.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

using voxel::VoxelState;

SearchSettings quick() {
  SearchSettings s;
  s.method = SearchMethod::fast;
  s.fast.positions = 50;
  s.max_evaluations = 400;
  return s;
}

PlannedView plan(const Situation& s, std::uint64_t seed = 1, const SearchSettings& search = quick()) {
  return plan_view(s, seed, search, {}, {});
}

TEST(ViewSearch, LooksAtTheOnlyUnknownSide) {
  const PlannedView v = plan(testing::patch_at_plus_x());
  EXPECT_GT(v.X_WC.translation().x(), 0.5);
  EXPECT_GE(v.evaluation.gain.voxels, 220);  // of 225
  EXPECT_EQ(v.evaluation.violation, Violation::none);
  EXPECT_LE(v.evaluations, 400);
  EXPECT_FALSE(v.landmark_term);
}

TEST(ViewSearch, BeatsItsOwnSamples) {
  // An uneven object: the local searches have something to find.
  const Situation s = testing::around_the_origin(25, [](int x, int y, int z) {
    const double r = std::hypot(x - 12, y - 12) + 3 * std::sin(z * 0.7 + x * 0.5);
    return r > 11 ? VoxelState::empty : (x + 2 * y) % 11 < 6 && x > 8 ? VoxelState::unknown : VoxelState::known;
  });
  const PlannedView v = plan(s, 2);
  EXPECT_GT(v.gain_scale, 100);
  // gain_scale is the greatest N_u of the samples; the answer pays penalties and still comes near to or beyond it.
  EXPECT_LT(v.f_e, -0.9 * v.gain_scale);
}

TEST(ViewSearch, DoesNotLookThroughAWall) {
  // A wall through the whole room, so close to the unknown side that no head fits between.
  scene::Scene scene;
  scene.solids.push_back(testing::box({0.28, 0.0, 1.4}, {0.02, 6.0, 2.8}));
  const Situation walled = testing::patch_at_plus_x(scene);
  const PlannedView v = plan(walled, 3);
  // Of the layer of 15 x 15 unknown voxels only the rim shows from the sides: two edges of it at best.
  EXPECT_LE(v.evaluation.gain.voxels, 30);
  EXPECT_LT(v.X_WC.translation().x(), 0.27);

  // Half a wall: the view passes it on the open side, and sees the face.
  scene::Scene half;
  half.solids.push_back(testing::box({0.6, 0.75, 1.1}, {0.02, 1.5, 0.9}));
  const Situation open = testing::patch_at_plus_x(half);
  const PlannedView w = plan(open, 3);
  EXPECT_GT(w.evaluation.gain.voxels, 150);
  const Eigen::Vector3d eye = w.X_WC.translation();
  EXPECT_FALSE(open.collision->first_hit(eye, {0.151, -0.1, 1.1}).has_value());
}

TEST(ViewSearch, AForbiddenAnswerIsNotGivenAgain) {
  Situation s = testing::patch_at_plus_x();
  for (int i = 0; i < 4; ++i) {
    const PlannedView v = plan(s, 4);
    for (const Pose& F : s.forbidden) {
      const double distance = (F.translation() - v.X_WC.translation()).norm();
      EXPECT_TRUE(distance > 0.10 || angle_between(F, v.X_WC) > 10 * std::numbers::pi / 180) << i << " " << distance;
    }
    s.forbidden.push_back(v.X_WC);
  }
}

TEST(ViewSearch, NothingUnknownGivesNoGainButAView) {
  const Situation s = testing::around_the_origin(15, [](int, int, int) { return VoxelState::known; });
  const PlannedView v = plan(s);
  EXPECT_EQ(v.evaluation.gain.voxels, 0);
  EXPECT_EQ(v.evaluation.gain.pixels, 0u);
  EXPECT_EQ(v.evaluation.violation, Violation::none);
}

TEST(ViewSearch, SaysWhenNoPlaceIsReachable) {
  Situation s = testing::patch_at_plus_x();
  s.limits.height_min = 2.75;  // the head would be in the ceiling
  s.limits.height_max = 2.79;
  try {
    plan(s);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::nbv_no_reachable_view);
  }
  s.limits.height_max = std::nan("");
  EXPECT_THROW(plan(s), Error);
}

TEST(ViewSearch, LandmarksKeepSomeOfTheKnownInView) {
  Situation s = testing::around_the_origin(15, [](int x, int, int) { return x > 4 ? VoxelState::unknown : VoxelState::known; });
  for (int i = 0; i < 40; ++i) {  // on the known part of the side at +y
    s.landmarks.push_back({{-0.14 + 0.02 * (i % 5), 0.149, 0.98 + 0.02 * (i / 5)}, {0, 1, 0}, 0.02});
  }
  const PlannedView v = plan(s, 5);
  EXPECT_TRUE(v.landmark_term);
  EXPECT_GE(v.evaluation.visible_landmarks, 5);
  EXPECT_GT(v.evaluation.gain.voxels, 50);
  EXPECT_GT(v.X_WC.translation().y(), 0.3);
}

bool same(const PlannedView& a, const PlannedView& b) {
  return std::memcmp(a.X_WC.matrix().data(), b.X_WC.matrix().data(), 16 * sizeof(double)) == 0 && a.f_e == b.f_e &&
         a.evaluations == b.evaluations && a.evaluation.gain.pixels == b.evaluation.gain.pixels;
}

TEST(ViewSearch, SameBytesForAnyNumberOfThreads) {
  const Situation s = testing::around_the_origin(20, [](int x, int y, int z) {
    return (x * y + z) % 7 == 0 ? VoxelState::empty : (x + y * z) % 3 == 0 ? VoxelState::unknown : VoxelState::known;
  });
  SearchSettings search = quick();
  search.threads = 1;
  const PlannedView one = plan(s, 6, search);
  for (int threads : {2, 3}) {
    search.threads = threads;
    EXPECT_TRUE(same(one, plan(s, 6, search))) << threads;
  }
  EXPECT_FALSE(same(one, plan(s, 7, search)));
}

// Every result as another process would send it.
class WritingRunner : public ThreadRunner {
 public:
  WritingRunner() : ThreadRunner(1) {}
  int read = 0;

 protected:
  void run(const Stage& stage) override {
    ThreadRunner::run(stage);
    for (int i = stage.count - 1; i >= 0; --i, ++read) {
      Numbers numbers;
      stage.write(i, numbers);
      stage.compute((i + 1) % stage.count, 0);  // what a worker did before must not show
      stage.read(i, numbers);
    }
  }
};

TEST(ViewSearch, SameBytesIfOtherProcessesDidTheTasks) {
  const Situation s = testing::around_the_origin(20, [](int x, int y, int z) {
    return (x * y + z) % 7 == 0 ? VoxelState::empty : (x + y * z) % 3 == 0 ? VoxelState::unknown : VoxelState::known;
  });
  SearchSettings search = quick();
  search.fast.positions = 24;
  search.max_evaluations = 150;
  WritingRunner runner;
  const Evaluator evaluator(s, {}, {});
  EXPECT_TRUE(same(plan(s, 6, search), plan_view(evaluator, 6, search, runner)));
  EXPECT_GT(runner.read, 30);
}

TEST(ViewSearch, WithoutTimeTheBestOfAFewComesBack) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  ThreadRunner none(2, ThreadRunner::Clock::now());
  const PlannedView v = plan_view(evaluator, 1, quick(), none);
  EXPECT_TRUE(v.cut_short);
  EXPECT_EQ(v.evaluation.violation, Violation::none);
  EXPECT_GT(v.evaluation.gain.voxels, 0);
  EXPECT_LT(v.evaluations, 40);
  ThreadRunner enough(2, ThreadRunner::Clock::now() + std::chrono::hours(1));
  const PlannedView w = plan_view(evaluator, 1, quick(), enough);
  EXPECT_FALSE(w.cut_short);
  EXPECT_TRUE(same(w, plan(s)));
}

TEST(ViewSearch, TimeIsNoReasonToCallAPlaceUnreachable) {
  // Only a few of the places drawn are feasible: a narrow ring of distances.
  Situation s = testing::patch_at_plus_x();
  s.limits.distance_min = 0.9;
  s.limits.distance_max = 0.93;
  const Evaluator evaluator(s, {}, {});
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    ThreadRunner none(1, ThreadRunner::Clock::now());
    EXPECT_EQ(plan_view(evaluator, seed, quick(), none).evaluation.violation, Violation::none);
  }
}

TEST(ViewSearch, PollMayGiveUp) {
  const Situation s = testing::patch_at_plus_x();
  const auto give_up = [](double) { throw std::runtime_error("cancelled"); };
  EXPECT_THROW(plan_view(s, 1, quick(), {}, {}, give_up), std::runtime_error);
}

TEST(ViewSearch, HardConstraintsHoldInManySituations) {
  Random random(8);
  int found = 0;
  for (int i = 0; i < 20; ++i) {
    scene::Scene scene;
    scene.solids.push_back(testing::box({0, 0, 0.36}, {0.7, 0.7, 0.72}));  // a table
    for (int k = 0; k < 4; ++k) {
      const double a = random.uniform(-3.1, 3.1), r = random.uniform(0.8, 2.0);
      const double h = random.uniform(0.3, 1.8);
      scene.solids.push_back(testing::box({r * std::cos(a), r * std::sin(a), h / 2},
                                          {random.uniform(0.1, 0.5), random.uniform(0.1, 0.5), h}));
    }
    const double cut = random.uniform(-8, 8), fx = random.uniform(-1, 1), fy = random.uniform(-1, 1);
    Situation s = testing::around_the_origin(
        18,
        [&](int x, int y, int z) {
          const Eigen::Vector3d p(x - 8.5, y - 8.5, z - 8.5);
          if (p.norm() > 8 + std::sin(x + i)) return VoxelState::empty;
          return fx * p.x() + fy * p.y() > cut * 0.5 ? VoxelState::unknown : VoxelState::known;
        },
        scene);
    for (int k = 0; k < 3; ++k) {
      const double a = random.uniform(-3.1, 3.1);
      s.forbidden.push_back(look_at({1.1 * std::cos(a), 1.1 * std::sin(a), 1.2}, {0, 0, 1.1}));
    }
    SearchSettings search = quick();
    search.max_evaluations = 300;
    const PlannedView v = plan(s, static_cast<std::uint64_t>(i), search);
    found += v.evaluation.gain.voxels > 0;
    // Written out again rather than asked of Constraints.
    const Eigen::Vector3d left = v.X_WC.translation(), right = v.X_WC * Eigen::Vector3d(0.144, 0, 0);
    const Eigen::Vector3d ypr = camera_yaw_pitch_roll(v.X_WC);
    EXPECT_GE(left.z(), 1.0);
    EXPECT_LE(left.z(), 1.35);
    EXPECT_GE(ypr.y(), s.limits.pitch_min);
    EXPECT_LE(ypr.y(), s.limits.pitch_max);
    EXPECT_NEAR(ypr.z(), 0, 1e-9);
    double nearest = 1e9;
    for (int x = 0; x < 18; ++x) {
      for (int y = 0; y < 18; ++y) {
        for (int z = 0; z < 18; ++z) {
          if (s.grid->state({x, y, z}) == VoxelState::empty) continue;
          nearest = std::min(nearest, (s.grid->geometry().center_world({x, y, z}) - left).norm());
        }
      }
    }
    EXPECT_GE(nearest, 0.6);
    EXPECT_LE(nearest, 2.5);
    for (const auto& p : {left, right}) {
      EXPECT_FALSE(s.collision->contains(p, 0.149));
      EXPECT_LT(std::max(std::abs(p.x()), std::abs(p.y())), 3 - 0.149);
    }
    const Pose X_base = to_pose({(left.x() + right.x()) / 2 - 0.1 * std::cos(ypr.x()),
                                 (left.y() + right.y()) / 2 - 0.1 * std::sin(ypr.x()), ypr.x()});
    EXPECT_FALSE(s.collision->box_collides(X_base * Pose(Eigen::Translation3d(0, 0, 0.78)), {0.38, 0.58, 1.5}));
    for (const Pose& F : s.forbidden) {
      EXPECT_TRUE((F.translation() - left).norm() > 0.10 || angle_between(F, v.X_WC) > 10 * std::numbers::pi / 180);
    }
  }
  EXPECT_GE(found, 15);
}

// A known plate, and 0.3 m behind it an unknown one of which no voxel is near the known.
Situation two_plates() {
  return testing::around_the_origin(20, [](int x, int, int) {
    return x == 0 ? voxel::VoxelState::known : x == 19 ? voxel::VoxelState::unknown : voxel::VoxelState::empty;
  });
}

TEST(ViewSearch, WhatIsLeftFarFromTheKnownIsFoundAllTheSame) {
  const Situation s = two_plates();
  EvaluationSettings near;
  near.likely_within = 3;
  const PlannedView v = plan_view(s, 2, {}, near, {});
  EXPECT_GT(v.evaluation.gain.voxels, 200);
  EXPECT_GT(v.evaluation.value, 200);
}

TEST(ViewSearch, ListsAreJudgedAlike) {
  const Pose at_known = look_along({-1.3, 0.072, 1.1}, 0, 0), at_unknown = look_along({1.3, -0.072, 1.1}, std::numbers::pi, 0);
  const Situation far = two_plates();
  EvaluationSettings near;
  near.likely_within = 3;
  Evaluator::Workspace w;
  EXPECT_EQ(choose_view(Evaluator(far, {}, {}), {at_known, at_unknown}, w).index, 1);
  EXPECT_EQ(choose_view(Evaluator(far, near, {}), {at_known, at_unknown}, w).index, 1);  // nothing likely: all of it counts
  EXPECT_THROW(choose_view(Evaluator(far, near, {}), {}, w), Error);
  // A strip that goes on from the known face at -x, and a larger shadow at +x: the strip first, if it is not too small.
  const Situation both = testing::around_the_origin(20, [](int x, int y, int) {
    return x == 0 ? (y < 10 ? voxel::VoxelState::known : voxel::VoxelState::unknown) : x == 19 ? voxel::VoxelState::unknown : voxel::VoxelState::empty;
  });
  EvaluationSettings reach = near;
  reach.likely_within = 8;
  const Pose strip = look_along({-1.3, 0.072, 1.1}, 0, 0);
  EXPECT_EQ(choose_view(Evaluator(both, {}, {}), {strip, at_unknown}, w).index, 1);
  EXPECT_EQ(choose_view(Evaluator(both, reach, {}), {strip, at_unknown}, w).index, 0);
}

TEST(ViewSearch, LikelySurfaceDecidesAndAllUnknownIsReported) {
  // A known face at -x of a block; one voxel deep beside it the unknown counts, the rest of the block does not.
  const Situation s = testing::around_the_origin(16, [](int x, int, int) {
    return x == 0 ? voxel::VoxelState::known : voxel::VoxelState::unknown;
  });
  EvaluationSettings near;
  near.likely_within = 1;
  const PlannedView v = plan_view(s, 2, {}, near, {});
  Evaluator::Workspace w;
  const Evaluator everything(s, {}, {});
  EXPECT_EQ(v.evaluation.gain.voxels, everything.evaluate(v.X_WC, w).gain.voxels);
  EXPECT_EQ(v.evaluation.value, Evaluator(s, near, {}).evaluate(v.X_WC, w).value);
  EXPECT_NE(v.evaluation.value, v.evaluation.gain.voxels);
}

TEST(ViewSearch, LookingAheadTakesAViewNearTheBest) {
  const Situation s = testing::patch_at_plus_x();
  SearchSettings search;
  search.method = SearchMethod::fast;
  const PlannedView greedy = plan_view(s, 4, search, {}, {});
  search.lookahead.depth = 3;
  search.lookahead.within = 0.1;
  const PlannedView ahead = plan_view(s, 4, search, {}, {});
  EXPECT_GE(ahead.evaluation.value, 0.9 * greedy.evaluation.value - 1);
  EXPECT_EQ(ahead.evaluation.violation, Violation::none);
  EXPECT_TRUE(ahead.candidates.empty());
  search.threads = 1;
  EXPECT_TRUE(plan_view(s, 4, search, {}, {}).X_WC.isApprox(ahead.X_WC, 0));
  search.lookahead.depth = 4;
  EXPECT_THROW(plan_view(s, 4, search, {}, {}), Error);
}

}  // namespace
}  // namespace periplus::nbv
