#include "services/nbv_planner/search_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/core/error.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

// A search of the patch at +x, with all that it refers to.
struct PatchSearch {
  explicit PatchSearch(int max_evaluations = 100, Bounds bounds = Bounds::all, Situation s = testing::patch_at_plus_x(), const EvaluationSettings& e = {})
      : situation(std::move(s)), evaluator(situation, e, {}), runner(1) {
    settings.max_evaluations = max_evaluations;
    settings.keep_candidates = true;
    frame.emplace(evaluator, 7, settings, runner, bounds, poll);
  }
  Situation situation;
  Evaluator evaluator;
  SearchSettings settings;
  ThreadRunner runner;
  std::function<void(double)> poll;
  std::optional<SearchFrame> frame;
};

const PlaceSampling kOrdered{.height_share = 1, .nearness = 1.5, .ordered = true};  // as panorama_search draws
const Pose kFront = look_along({1.3, -0.072, 1.1}, std::numbers::pi, 0), kBack = look_along({-1.3, 0.072, 1.1}, 0, 0);

TEST(SearchFrame, TermsWhoseLimitsAreBoundsAreLeftOutOfTheScore) {
  const PatchSearch s;
  Evaluation e;
  e.value = 10;
  e.k_height = 1;
  e.k_roll = 2;
  e.k_pitch = 4;
  e.k_yaw = 8;
  e.k_distance = 16;
  e.k_far = 32;
  Evaluation without_intervals = e, without_any = e;
  without_intervals.k_height = without_intervals.k_roll = without_intervals.k_pitch = without_intervals.k_yaw = 0;
  without_any = without_intervals;
  without_any.k_distance = without_any.k_far = 0;
  EXPECT_EQ(bounded_score(s.evaluator, e, 100, Bounds::none), s.evaluator.score(e, 100));
  EXPECT_EQ(bounded_score(s.evaluator, e, 100, Bounds::intervals), s.evaluator.score(without_intervals, 100));
  EXPECT_EQ(bounded_score(s.evaluator, e, 100, Bounds::all), s.evaluator.score(without_any, 100));
  EXPECT_NEAR(bounded_score(s.evaluator, e, 100, Bounds::all), -10, 1e-12);
  EXPECT_NEAR(bounded_score(s.evaluator, e, 100, Bounds::none) - bounded_score(s.evaluator, e, 100, Bounds::intervals), 100 * (1 + 2 + 4 + 8), 1e-9);
}

TEST(SearchFrame, GainGoesBeforeScoreAndWhatBreaksAConstraintNeverWins) {
  PatchSearch s;
  SearchFrame& f = *s.frame;
  f.greatest = 100;
  Candidate much, little, none, forbidden;
  much.evaluation.value = 50;
  little.evaluation.value = 1;
  little.evaluation.k_forbidden = 1;  // its score is the worst of the three
  none.evaluation.value = 0;
  forbidden.evaluation.value = 90;
  forbidden.evaluation.violation = Violation::forbidden;
  EXPECT_GT(f.score(little.evaluation), f.score(none.evaluation));
  EXPECT_TRUE(f.better(little, none));
  EXPECT_FALSE(f.better(none, little));
  EXPECT_TRUE(f.better(much, little));
  EXPECT_FALSE(f.better(much, much)) << "the first of equals stays";
  f.offer(forbidden);
  EXPECT_FALSE(f.best.has_value());
  f.offer(none);
  f.offer(little);
  EXPECT_EQ(f.best->evaluation.value, 1);
  f.offer(much);
  f.offer(little);
  f.offer(forbidden);
  EXPECT_EQ(f.best->evaluation.value, 50);
}

TEST(SearchFrame, EvaluatesAsManyAsTheBudgetLets) {
  PatchSearch s(10);
  SearchFrame& f = *s.frame;
  const std::vector<Pose> poses(7, kFront);
  EXPECT_EQ(f.evaluate(poses).size(), 7u);
  EXPECT_EQ(f.left(), 3);
  const std::vector<Candidate> rest = f.evaluate({kBack, kFront, kFront, kFront, kFront});
  ASSERT_EQ(rest.size(), 3u) << "the first ones";
  EXPECT_EQ(rest[0].evaluation.gain.voxels, 0);
  EXPECT_EQ(rest[1].evaluation.gain.voxels, 225);
  EXPECT_EQ(rest[1].X_WC.matrix(), kFront.matrix());
  EXPECT_EQ(f.left(), 0);
  EXPECT_TRUE(f.evaluate(poses).empty());
  EXPECT_EQ(f.evaluate(poses, 2).size(), 2u) << "what must be looked at in any case";
  EXPECT_EQ(f.evaluations, 12);
}

// Three quarters for a free face of an unknown voxel and on the side that it looks to, the others all around; all of them allowed.
TEST(SearchFrame, PlacesAreAllowedAndMostlyOnTheSideOfTheUnknown) {
  for (const PlaceSampling& sampling : {PlaceSampling{}, kOrdered}) {
    PatchSearch s;
    SearchFrame& f = *s.frame;
    EXPECT_EQ(f.faces.size(), s.evaluator.visibility().unknown_face_count());
    const robot::ViewLimits& limits = s.situation.limits;
    int in_front = 0, behind = 0;
    double nearest = 10, lowest = 10, highest = 0;
    std::set<double> all;
    for (int i = 0; i < 400; ++i) {
      Random random = f.random(0, i);
      const auto place = f.draw_place(i, sampling, random);
      ASSERT_TRUE(place.has_value()) << i;
      const Eigen::Vector3d& p = place->p_W;
      EXPECT_EQ(f.evaluator.constraints().check_position(p, std::atan2(place->from.y() - p.y(), place->from.x() - p.x())), Violation::none);
      EXPECT_GE(p.z(), limits.height_min);
      EXPECT_LE(p.z(), limits.height_max);
      EXPECT_GE(s.evaluator.constraints().nearest_voxel(p), limits.distance_min - 1e-9);
      EXPECT_LE(s.evaluator.constraints().nearest_voxel(p), limits.distance_max + 1e-9);
      (p.x() > 0.15 ? in_front : behind) += 1;
      nearest = std::min(nearest, s.evaluator.constraints().nearest_voxel(p));
      lowest = std::min(lowest, p.z());
      highest = std::max(highest, p.z());
      all.insert(p.x());
      // The same task draws the same place, whoever runs it.
      Random again = f.random(0, i);
      EXPECT_EQ(f.draw_place(i, sampling, again)->p_W, p);
    }
    EXPECT_EQ(all.size(), 400u);
    EXPECT_LT(nearest, 0.75);
    EXPECT_EQ(lowest, limits.height_min) << "many of the best views lie at a bound";
    EXPECT_EQ(highest, limits.height_max);
    // The unknown is the whole face at +x and the rim of its neighbours; of what is drawn all around some half is behind.
    EXPECT_GT(in_front, 240);
    EXPECT_GT(behind, 30);
  }
}

// So that many lie as near as they may, and what is far enough stays where it is.
TEST(SearchFrame, PlacesThatAreTooNearAreMovedBack) {
  PatchSearch s;
  const Constraints& constraints = s.evaluator.constraints();
  const double least = s.situation.limits.distance_min;
  for (double x : {0.3, 0.5, 0.7, 1.4}) {
    const Eigen::Vector3d before(x, 0, 1.1);
    Eigen::Vector3d p = before;
    s.frame->move_back(p, std::numbers::pi);  // looks at the patch
    EXPECT_EQ(p.z(), before.z());
    if (constraints.nearest_voxel(before) >= least) {
      EXPECT_EQ(p, before);
    } else {
      EXPECT_GE(constraints.nearest_voxel(p), least);
      EXPECT_LE(constraints.nearest_voxel(p), least + 0.01);
    }
  }
}

TEST(SearchFrame, PlacesAreInSightOfTheFacesThatTheyWereDrawnForWhereThereAreSuch) {
  // A wall hides the patch from everywhere on its side but for the gap at +y.
  scene::Scene scene;
  scene.room.size = {8, 8, 3};
  scene.solids = {testing::box({0.5, -0.6, 1.25}, {0.05, 1.9, 2.5})};
  PatchSearch s(100, Bounds::all, testing::patch_at_plus_x(scene));
  for (const PlaceSampling& sampling : {PlaceSampling{}, kOrdered}) {
    int hidden = 0, drawn = 0;
    for (int i = 0; i < 300; ++i) {
      if (i % 4 == 3) continue;  // drawn around the box, whatever hides it
      Random random = s.frame->random(0, i);
      const auto place = s.frame->draw_place(i, sampling, random);
      ASSERT_TRUE(place.has_value());
      ++drawn;
      hidden += s.situation.collision->first_hit(place->p_W, place->from).has_value();
    }
    EXPECT_LT(hidden, drawn / 5);
  }
}

TEST(SearchFrame, TasksHaveRandomNumbersOfTheirOwn) {
  const PatchSearch s;
  std::set<std::uint64_t> first;
  for (int stage = 0; stage < 20; ++stage)
    for (int i = 0; i < 50; ++i) {
      Random random = s.frame->random(stage, i);
      first.insert(random.below(std::numeric_limits<std::uint32_t>::max()));
    }
  EXPECT_EQ(first.size(), 1000u);
}

TEST(SearchFrame, TheAnswerIsTheBestWithItsTermsAndStages) {
  PatchSearch s;
  double polled = 0;
  s.poll = [&](double share) { polled = share; };
  SearchFrame& f = *s.frame;
  f.greatest = 225;
  for (const Candidate& c : f.evaluate({kBack, kFront})) {
    f.offer(c);
    f.note(c.X_WC, f.score(c.evaluation), "some");
  }
  f.end_stage("some", 0.5);
  EXPECT_EQ(polled, 0.5);
  const PlannedView view = f.finish();
  EXPECT_EQ(polled, 1);
  EXPECT_EQ(view.X_WC.matrix(), kFront.matrix());
  EXPECT_EQ(view.evaluation.gain.voxels, 225);
  EXPECT_EQ(view.evaluations, 2);
  EXPECT_EQ(view.gain_scale, 225);
  EXPECT_FALSE(view.cut_short);
  EXPECT_FALSE(view.landmark_term);
  EXPECT_EQ(view.candidates.size(), 2u);
  ASSERT_EQ(view.seconds.size(), 1u);
  EXPECT_EQ(view.seconds[0].first, "some");
  EXPECT_NEAR(view.f_e, -225, 1e-9) << "the bounds' terms are left out";
  EXPECT_EQ(view.terms.at(0).first, "f_e");
  EXPECT_EQ(view.terms.at(0).second, view.f_e);
}

TEST(SearchFrame, NothingReachableIsAnErrorOfItsOwn) {
  const PatchSearch s;
  try {
    s.frame->throw_unreachable();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::nbv_no_reachable_view);
  }
}

}  // namespace
}  // namespace periplus::nbv
