#include "services/walk_planner/footstep_planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::walk {
namespace {

constexpr double kHalfWidth = 0.095;

// A posture's feet about a body pose: as random as the limits of postures allow.
Feet posture_feet(const Pose2& body, Random& random) {
  const StepSettings s;
  for (;;) {
    const double dx = random.uniform(-0.16, 0.16), width = random.uniform(0.15, 0.27),
                 open = random.uniform(-0.15, 0.65);
    const double share = random.uniform();
    const Feet feet{compose(body, {0.5 * dx, 0.5 * width, share * open}),
                    compose(body, {-0.5 * dx, -0.5 * width, -(1 - share) * open})};
    if (may_land(s, feet.left, feet.right, false, true) && may_land(s, feet.right, feet.left, true, true)) return feet;
  }
}

// Alternating, every landing within the limits, both feet at the goal at the end.
void expect_walk(const Feet& start, const Feet& goal, const std::vector<Footstep>& steps) {
  const StepSettings s;
  Feet feet = start;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (i > 0) {
      EXPECT_NE(steps[i].left, steps[i - 1].left) << "step " << i;
    }
    const bool left = steps[i].left;
    const Pose2& standing = left ? feet.right : feet.left;
    const Pose2& wanted = left ? goal.left : goal.right;
    const bool last_stance = i + 2 >= steps.size() && steps[i].sole.x == wanted.x && steps[i].sole.y == wanted.y;
    EXPECT_TRUE(may_land(s, standing, steps[i].sole, left, false) ||
                (last_stance && may_land(s, standing, steps[i].sole, left, true)))
        << "step " << i << " of " << steps.size();
    (left ? feet.left : feet.right) = steps[i].sole;
  }
  EXPECT_EQ(feet.left.x, goal.left.x);
  EXPECT_EQ(feet.left.y, goal.left.y);
  EXPECT_EQ(feet.left.yaw, goal.left.yaw);
  EXPECT_EQ(feet.right.x, goal.right.x);
  EXPECT_EQ(feet.right.y, goal.right.y);
  EXPECT_EQ(feet.right.yaw, goal.right.yaw);
}

TEST(FootstepPlanner, WalksStraight) {
  const Feet start = stance({0, 0, 0}, kHalfWidth), goal = stance({2, 0, 0}, kHalfWidth);
  const std::vector<Footstep> steps = plan_footsteps(start, goal, {{0, 0, 0}, {2, 0, 0}}, kHalfWidth);
  expect_walk(start, goal, steps);
  EXPECT_LE(steps.size(), 13u);  // 0.2 m a step and one to close
}

TEST(FootstepPlanner, TurnsAndSideSteps) {
  const Feet start = stance({0, 0, 0}, kHalfWidth);
  const Pose2 turned{0, 0, std::numbers::pi}, beside{0, -0.5, 0};
  for (const Pose2& to : {turned, beside}) {
    const Feet goal = stance(to, kHalfWidth);
    const std::vector<Footstep> steps = plan_footsteps(start, goal, {{0, 0, 0}, to}, kHalfWidth);
    expect_walk(start, goal, steps);
    EXPECT_LE(steps.size(), 20u);
  }
}

TEST(FootstepPlanner, FeetThatStandThereAlreadyDoNotMove) {
  Random random(3);
  const Feet feet = posture_feet({0.3, -0.2, 1}, random);
  EXPECT_TRUE(plan_footsteps(feet, feet, {middle(feet)}, kHalfWidth).empty());
}

TEST(FootstepPlanner, AnyPosturesFeetToAnyOthersAlongAnyPath) {
  Random random(17);
  for (int n = 0; n < 300; ++n) {
    const auto pose = [&random](double range) {
      return Pose2{random.uniform(-range, range), random.uniform(-range, range), random.uniform(-3.1, 3.1)};
    };
    const Pose2 a = pose(1);
    // Now and then near each other: rearranging the feet where they stand.
    const Pose2 b = n % 4 == 0
                        ? compose(a, {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.2, 0.2)})
                        : pose(2);
    const Feet start = posture_feet(a, random), goal = posture_feet(b, random);
    std::vector<Pose2> path{middle(start)};
    if (n % 3 == 0) path.push_back(pose(2));
    path.push_back(middle(goal));
    const std::vector<Footstep> steps = plan_footsteps(start, goal, path, kHalfWidth);
    expect_walk(start, goal, steps);
    ASSERT_GE(steps.size(), 1u);
    const std::vector<Footstep> again = plan_footsteps(start, goal, path, kHalfWidth);
    ASSERT_EQ(again.size(), steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) EXPECT_EQ(again[i].sole.x, steps[i].sole.x);
  }
}

TEST(FootstepPlanner, FeetThatCannotStandSoAreRefused) {
  const Feet start = stance({0, 0, 0}, kHalfWidth);
  Feet goal = stance({1, 0, 0}, 0.25);  // half a metre apart
  try {
    plan_footsteps(start, goal, {{0, 0, 0}, {1, 0, 0}}, kHalfWidth);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::walk_no_path);
  }
}

TEST(FootstepPlanner, OutwardIsMirrored) {
  const Feet feet = stance({1, 2, 0.7}, kHalfWidth);
  const Pose2 left = outward(feet.right, feet.left, true), right = outward(feet.left, feet.right, false);
  EXPECT_NEAR(left.y, 2 * kHalfWidth, 1e-12);
  EXPECT_NEAR(right.y, 2 * kHalfWidth, 1e-12);
  EXPECT_GT(outward(feet.right, compose(feet.left, {0, 0, 0.1}), true).yaw, 0.09);
  EXPECT_GT(outward(feet.left, compose(feet.right, {0, 0, -0.1}), false).yaw, 0.09);
}

TEST(FootstepPlanner, BadSettingsAreRefused) {
  StepSettings s;
  s.step.y_min = 0.3;
  EXPECT_THROW(s.check(), Error);
  EXPECT_NO_THROW(StepSettings().check());
}

}  // namespace
}  // namespace periplus::walk
