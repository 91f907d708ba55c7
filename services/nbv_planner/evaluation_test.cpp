#include "services/nbv_planner/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "common/core/error.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

TEST(Evaluation, TermsAreThoseOfTheThesis) {
  Situation s = testing::patch_at_plus_x();
  s.limits.roll_max = 0.1;
  s.forbidden.push_back(look_along({1.5, 0.3, 1.2}, std::numbers::pi, 0.2));
  const Evaluator evaluator(s, {}, {});
  Evaluator::Workspace w;
  const Evaluation e = evaluator.evaluate(look_along({1.2, 0, 1.1}, std::numbers::pi - 0.05, 0.1, 0.05), w);
  const double pitch_low = s.limits.pitch_min, pitch_high = s.limits.pitch_max;
  EXPECT_NEAR(e.k_height, std::pow((1.1 - 1.175) / 0.175, 6), 1e-9);
  EXPECT_NEAR(e.k_roll, std::pow(0.5, 6), 1e-9);
  EXPECT_NEAR(e.k_pitch, std::pow((0.1 - (pitch_low + pitch_high) / 2) / ((pitch_high - pitch_low) / 2), 6), 1e-9);
  const double distance = Eigen::Vector3d(1.2 - 0.14, 0, 0).norm();  // a voxel's centre lies at y = 0, z = 1.1
  EXPECT_NEAR(e.k_distance, std::exp(20 * (0.6 - distance)), 1e-9);
  EXPECT_NEAR(e.k_far, std::exp(20 * (distance - 2.5)), 1e-12);
  EXPECT_NEAR(e.k_forbidden, std::exp(-(0.3 + 0.3 + 0.1 + 0.05 + 0.1 + 0.05)), 1e-9);
  EXPECT_EQ(e.violation, Violation::none);
  EXPECT_GT(e.gain.voxels, 100);
  EXPECT_NEAR(evaluator.score(e, 200),
              200 * (e.k_height + e.k_roll + e.k_pitch) + 100 * (e.k_distance + e.k_far) + 200 * e.k_forbidden - e.gain.voxels,
              1e-9);
  EXPECT_NEAR(evaluator.score(e, 5000),
              5000 * (e.k_height + e.k_roll + e.k_pitch) + 100 * (e.k_distance + e.k_far) + 1000 * e.k_forbidden - e.gain.voxels,
              1e-9);
}

TEST(Evaluation, ABoundCostsAsMuchAsTheBestGain) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  Evaluator::Workspace w;
  EXPECT_NEAR(evaluator.evaluate(look_along({1.2, 0, 1.35}, std::numbers::pi, 0.2), w).k_height, 1, 1e-9);
  EXPECT_NEAR(evaluator.evaluate(look_along({1.2, 0, 1.0}, std::numbers::pi, 0.2), w).k_height, 1, 1e-9);
  EXPECT_NEAR(evaluator.evaluate(look_along({0.74, 0, 1.1}, std::numbers::pi, 0.2), w).k_distance, 1, 1e-9);
}

TEST(Evaluation, GainIsTheUnknownFace) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  Evaluator::Workspace w;
  // From 1.2 m both eyes see the whole face of 15 x 15 voxels (0.3 m of 0.39 m that they share); from behind nothing.
  const Evaluation front = evaluator.evaluate(look_along({1.3, -0.072, 1.1}, std::numbers::pi, 0), w);
  EXPECT_EQ(front.gain.voxels, 225);
  const Evaluation back = evaluator.evaluate(look_along({-1.3, 0.072, 1.1}, 0, 0), w);
  EXPECT_EQ(back.gain.voxels, 0);
  EXPECT_EQ(back.gain.pixels, 0u);
  EXPECT_LT(evaluator.score(front, 225), evaluator.score(back, 225));
}

TEST(Evaluation, QuantificationsCountPixelsVoxelsOrVoxelsAboveTheThreshold) {
  const Situation s = testing::patch_at_plus_x();
  EvaluationSettings settings;
  settings.pixels_per_voxel_share = 0;
  settings.pair.more_than_pixels = 300;
  const Pose X = look_along({1.3, -0.072, 1.1}, std::numbers::pi, 0);
  Evaluator::Workspace w;
  std::map<Quantification, Evaluation> by;
  for (Quantification q : {Quantification::pixels, Quantification::voxels, Quantification::mixed}) {
    settings.quantification = q;
    by[q] = Evaluator(s, settings, {}).evaluate(X, w);
  }
  // Each of the 225 faces fills (1082.6 * 0.02 / 1.15)^2 = 354 pixels; the depth is the same all over the face.
  const double face = std::pow(s.rig.camera.fx * 0.02 / 1.15, 2);
  EXPECT_NEAR(by[Quantification::pixels].value, 225 * face, 0.03 * 225 * face);
  EXPECT_EQ(by[Quantification::voxels].value, 225);
  EXPECT_EQ(by[Quantification::mixed].value, 225);
  settings.pair.more_than_pixels = 400;
  EXPECT_EQ(Evaluator(s, settings, {}).evaluate(X, w).value, 0);
  settings.quantification = Quantification::voxels;
  EXPECT_EQ(Evaluator(s, settings, {}).evaluate(X, w).value, 225);
}

TEST(Evaluation, ThresholdGrowsWithTheVoxel) {
  Situation s = testing::patch_at_plus_x();  // voxels of 2 cm: 8.66 px at 2.5 m, a fifth of a face is 15.0
  EXPECT_EQ(Evaluator(s, {}, {}).settings().pair.more_than_pixels, 15);
  EvaluationSettings half;
  half.pixels_per_voxel_share = 0.5;
  EXPECT_EQ(Evaluator(s, half, {}).settings().pair.more_than_pixels, 37);
  voxel::GridGeometry g = s.grid->geometry();
  g.voxel_size = 0.01;
  s.grid = std::make_shared<voxel::OccupancyGrid>(g);
  EXPECT_EQ(Evaluator(s, {}, {}).settings().pair.more_than_pixels, 5);
}

TEST(Evaluation, FactorsByEachRule) {
  const Situation s = testing::patch_at_plus_x();
  EvaluationSettings settings;
  settings.lambda_motion = 0.5;
  const auto factors = [&](LambdaRule rule, double greatest) {
    settings.lambda_rule = rule;
    return Evaluator(s, settings, {}).lambdas(greatest);
  };
  EXPECT_EQ(factors(LambdaRule::capped, 300).forbidden, 300);
  EXPECT_EQ(factors(LambdaRule::capped, 3000).forbidden, 1000);
  EXPECT_EQ(factors(LambdaRule::capped, 300).interval, 300);
  EXPECT_EQ(factors(LambdaRule::fixed, 300).forbidden, 1000);
  EXPECT_EQ(factors(LambdaRule::fixed, 300).interval, 300);
  EXPECT_EQ(factors(LambdaRule::fixed, 300).distance, 100);
  EXPECT_EQ(factors(LambdaRule::scaled, 300).distance, 300);
  EXPECT_EQ(factors(LambdaRule::scaled, 300).motion, 150);
  // 3.2.1.5: without a visible landmark the term costs the greatest N_u.
  settings.lambda_rule = LambdaRule::scaled;
  const Evaluator scaled(s, settings, {});
  EXPECT_NEAR(scaled.lambdas(300).landmarks * scaled.landmark_penalty(0), 300, 1e-9);
}

TEST(Evaluation, OnlyUnknownNearTheKnownCounts) {
  // A known plate of 15 x 15; before it, towards +x, three layers of unknown where y < 5, ten where y >= 5.
  const Situation s = testing::around_the_origin(15, [](int x, int y, int) {
    return x == 0 ? voxel::VoxelState::known : x <= (y < 5 ? 3 : 10) ? voxel::VoxelState::unknown : voxel::VoxelState::empty;
  });
  const Pose X = look_along({1.3, -0.072, 1.1}, std::numbers::pi, 0);
  Evaluator::Workspace w;
  const Evaluation whole = Evaluator(s, {}, {}).evaluate(X, w);
  EXPECT_GE(whole.gain.voxels, 225);
  EvaluationSettings near;
  near.likely_within = 3;  // the outer seven layers do not count, and do not hide what is behind
  const Evaluator evaluator(s, near, {});
  EXPECT_FALSE(evaluator.everything_counts());
  EXPECT_EQ(evaluator.evaluate(X, w).value, 225);
  const Evaluation all_terms = evaluator.evaluate(X, w, Detail::every_term);
  EXPECT_EQ(all_terms.value, 225);
  EXPECT_EQ(all_terms.gain.voxels, whole.gain.voxels);  // what is reported is N_u all the same
  // They are obstacles still: the nearest occupied voxel is the outermost.
  EXPECT_EQ(evaluator.constraints().nearest_voxel(X.translation()), Evaluator(s, {}, {}).constraints().nearest_voxel(X.translation()));
}

TEST(Evaluation, YawHasItsLimits) {
  Situation s = testing::patch_at_plus_x();
  s.limits.yaw_min = 2.9;  // across pi
  s.limits.yaw_max = 3.5;
  const Evaluator evaluator(s, {}, {});
  Evaluator::Workspace w;
  const auto at = [&](double yaw) { return evaluator.evaluate(look_along({1.3, 0, 1.1}, yaw, 0), w); };
  EXPECT_NEAR(at(3.2).k_yaw, 0, 1e-9);
  EXPECT_NEAR(at(-std::numbers::pi + 0.05).k_yaw, 0, 1e-4);
  EXPECT_NEAR(at(2.9).k_yaw, 1, 1e-6);
  EXPECT_NEAR(at(3.35).k_yaw, std::pow(0.5, 6), 1e-6);
  EXPECT_EQ(at(2.85).violation, Violation::yaw);
  EXPECT_EQ(at(3.4).violation, Violation::none);
  const Situation free = testing::patch_at_plus_x();
  const Evaluator any(free, {}, {});
  EXPECT_EQ(any.evaluate(look_along({1.3, 0, 1.1}, 2.85, 0), w).k_yaw, 0);
}

TEST(Evaluation, MotionAndReachCost) {
  struct East final : Reachability {
    double of(const Pose& X) const override { return X.translation().y() > 0 ? 0.75 : 0; }
  };
  Situation s = testing::patch_at_plus_x();
  s.X_WC_now = look_along({1.3, 0.4, 1.1}, std::numbers::pi - 0.5, 0);
  s.reachability = std::make_shared<East>();
  EvaluationSettings settings;
  settings.motion_per_m = 0.3;
  settings.motion_per_rad = 0.2;
  settings.lambda_motion = 0.5;
  settings.lambda_reach = 2;
  const Evaluator evaluator(s, settings, {});
  Evaluator::Workspace w;
  const Evaluation e = evaluator.evaluate(look_along({1.3, 0.1, 1.1}, std::numbers::pi, 0), w);
  EXPECT_NEAR(e.k_motion, 0.3 * 0.3 + 0.2 * 0.5, 1e-9);
  EXPECT_NEAR(e.k_reach, 0.25, 1e-12);
  Evaluation still = e;
  still.k_motion = still.k_reach = 0;
  EXPECT_NEAR(evaluator.score(e, 200) - evaluator.score(still, 200), 200 * (0.5 * e.k_motion + 2 * 0.25), 1e-9);
}

TEST(Evaluation, WhatIsRuledOutIsNotRenderedAndCostsTheBestGain) {
  scene::Scene scene;
  scene.solids.push_back(testing::box({1.3, 0, 1.1}, {0.1, 0.1, 0.1}));
  const Situation s = testing::patch_at_plus_x(scene);
  const Evaluator evaluator(s, {}, {});
  Evaluator::Workspace w;
  const Evaluation e = evaluator.evaluate(look_along({1.3, 0, 1.1}, std::numbers::pi, 0), w);
  EXPECT_EQ(e.violation, Violation::head);
  EXPECT_EQ(e.gain.voxels, 0);
  EXPECT_GT(evaluator.score(e, 225), 225);
  // A map of the terms shows what would be seen from there all the same: from inside the box its own near side is not drawn.
  const Evaluation mapped = evaluator.evaluate(look_along({1.3, 0, 1.1}, std::numbers::pi, 0), w, Detail::every_term);
  EXPECT_EQ(mapped.violation, Violation::head);
  EXPECT_EQ(evaluator.terms(mapped, 225).at(0).second, evaluator.score(mapped, 225));
  EXPECT_THROW(evaluator.evaluate(look_along({std::nan(""), 0, 1.1}, 0, 0), w), Error);
}

Situation with_landmarks(int count) {
  Situation s = testing::patch_at_plus_x();
  for (int i = 0; i < count; ++i) {  // on the known face at -x
    s.landmarks.push_back({{-0.149, -0.14 + 0.02 * (i % 14), 0.96 + 0.02 * (i / 14)}, {-1, 0, 0}, 0.02});
  }
  return s;
}

TEST(Evaluation, LandmarkSigmoids) {
  const Situation s = with_landmarks(20);
  const Evaluator evaluator(s, {}, {});
  EXPECT_TRUE(evaluator.landmark_term());
  // 3.9 and 3.10 at their turning points: one half each.
  EXPECT_NEAR(evaluator.landmark_visibility(30, 30, {0, 0, 1}, {0, 0, 0}), 0.5, 1e-12);
  const double angle = 60 * std::numbers::pi / 180;
  EXPECT_NEAR(evaluator.landmark_visibility(1000, 30, {0, 0, 1}, {std::sin(angle), 0, -std::cos(angle)}), 0.5, 1e-9);
  EXPECT_NEAR(evaluator.landmark_visibility(1000, 30, {0, 0, 1}, {0, 0, -1}), 1, 1e-3);
  EXPECT_NEAR(evaluator.landmark_visibility(1000, 30, {0, 0, 1}, {0, 0, 1}), 0, 1e-3);
  // 3.12 and 3.13.
  EXPECT_NEAR(evaluator.landmark_penalty(7), -2, 1e-12);
  EXPECT_NEAR(evaluator.landmark_penalty(100), -5, 1e-12);
  EXPECT_NEAR(evaluator.landmark_penalty(0), 2 * 640 * 480, 1e-9);
  EXPECT_NEAR(evaluator.landmark_penalty(4), 2 * 640 * 480 / 25.0, 1e-9);
}

TEST(Evaluation, LandmarksAreSeenFromTheirSideOnly) {
  const Situation s = with_landmarks(20);
  const Evaluator evaluator(s, {}, {});
  Evaluator::Workspace w;
  EXPECT_GT(evaluator.evaluate(look_along({-1.3, 0.072, 1.1}, 0, 0), w).visible_landmarks, 15);
  EXPECT_LT(evaluator.evaluate(look_along({1.3, -0.072, 1.1}, std::numbers::pi, 0), w).visible_landmarks, 0.1);
}

TEST(Evaluation, NoLandmarksNoTerm) {
  const Situation none = testing::patch_at_plus_x(), few = with_landmarks(9), enough = with_landmarks(10);
  EXPECT_FALSE(Evaluator(none, {}, {}).landmark_term());
  EXPECT_FALSE(Evaluator(few, {}, {}).landmark_term());
  EXPECT_TRUE(Evaluator(enough, {}, {}).landmark_term());
  EvaluationSettings off;
  off.landmarks = false;
  EXPECT_FALSE(Evaluator(enough, off, {}).landmark_term());
  const Evaluator evaluator(none, {}, {});
  Evaluator::Workspace w;
  EXPECT_EQ(evaluator.evaluate(look_along({1.3, 0, 1.1}, std::numbers::pi, 0), w).k_landmarks, 0);
}

}  // namespace
}  // namespace periplus::nbv
