#include "services/nbv_planner/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>

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
