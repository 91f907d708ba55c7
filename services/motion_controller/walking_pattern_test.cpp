#include "services/motion_controller/walking_pattern.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"

namespace periplus::motion {
namespace {

const std::array<Pose2, 2> kFeet{Pose2{0, 0.095, 0}, Pose2{0, -0.095, 0}};
const Eigen::Vector3d kCom{0.012, 0, 0.8};

// Forward, turning a little.
std::vector<Step> walk(int count) {
  std::vector<Step> steps;
  Pose2 body{0, 0, 0};
  for (int i = 0; i < count; ++i) {
    if (i + 1 < count) body = compose(body, {0.18, 0, 0.05});
    steps.push_back({i % 2, compose(body, {0, i % 2 == 0 ? 0.095 : -0.095, 0})});
  }
  return steps;
}

// How far a point lies outside the convex hull of the standing soles (HRP-2-like rectangles) [m].
double outside(const PatternTick& tick, const Eigen::Vector2d& p) {
  std::vector<Eigen::Vector2d> corners;
  for (int f = 0; f < 2; ++f) {
    if (tick.support != 2 && tick.support != f) continue;
    const SolePose& s = tick.soles[static_cast<std::size_t>(f)];
    const double inner = 0.056, outer = 0.075;
    for (const double x : {-0.10, 0.13})
      for (const double y : {f == 0 ? -inner : -outer, f == 0 ? outer : inner}) {
        const Pose2 c = compose({s.position.x(), s.position.y(), s.yaw}, {x, y, 0});
        corners.emplace_back(c.x, c.y);
      }
  }
  // Separating direction: the farthest that p lies beyond all corners in any direction.
  double worst = -1e9;
  for (int k = 0; k < 720; ++k) {
    const Eigen::Vector2d d(std::cos(k * std::numbers::pi / 360), std::sin(k * std::numbers::pi / 360));
    double reach = -1e9;
    for (const Eigen::Vector2d& c : corners) reach = std::max(reach, d.dot(c));
    worst = std::max(worst, d.dot(p) - reach);
  }
  return worst;
}

void expect_sound(const WalkingPattern& pattern) {
  const std::vector<PatternTick>& ticks = pattern.ticks();
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    EXPECT_LT(outside(ticks[k], ticks[k].zmp), 0) << "tick " << k << ": zero-moment point outside the support polygon";
    if (k == 0) continue;
    for (int f = 0; f < 2; ++f) {
      const SolePose &a = ticks[k - 1].soles[static_cast<std::size_t>(f)],
                     &b = ticks[k].soles[static_cast<std::size_t>(f)];
      EXPECT_GE(b.position.z(), 0);
      if (ticks[k].support == 2 || ticks[k].support == f) {  // standing soles do not move
        EXPECT_EQ(a.position, b.position) << "tick " << k;
        EXPECT_EQ(a.yaw, b.yaw) << "tick " << k;
      } else {
        EXPECT_LT((b.position - a.position).norm(), 0.02);  // under 4 m/s
      }
    }
    // The speed is that of the positions, the zero-moment point that of the speeds (cart-table model).
    const PatternTick &a = ticks[k - 1], &b = ticks[k];
    const Eigen::Vector2d speed = (b.com - a.com) / 0.005, acceleration = (b.com_speed - a.com_speed) / 0.005;
    EXPECT_LT((0.5 * (a.com_speed + b.com_speed) - speed).norm(), 5e-4) << "tick " << k;
    EXPECT_LT((0.5 * (a.zmp + b.zmp - a.com - b.com) + kCom.z() / 9.81 * acceleration).norm(), 1e-4) << "tick " << k;
    EXPECT_LT(speed.norm(), 1);
  }
  const PatternTick& last = ticks.back();
  EXPECT_EQ(last.support, 2);
  // At rest where the weight shall be.
  EXPECT_LT(last.com_speed.norm(), 1e-9);
  EXPECT_LT((last.com - last.zmp_reference).norm(), 1e-9);
  EXPECT_LT((last.zmp - last.zmp_reference).norm(), 1e-9);
}

TEST(WalkingPattern, KeepsTheZeroMomentPointUnderTheSoles) {
  const std::vector<Step> steps = walk(10);
  const WalkingPattern pattern({}, kFeet, kCom, steps);
  expect_sound(pattern);
  const PatternTick& last = pattern.ticks().back();
  EXPECT_EQ(last.steps_done, 10);
  EXPECT_EQ(last.soles[0].position.x(), steps[8].sole.x);
  EXPECT_EQ(last.soles[1].position.y(), steps[9].sole.y);
  EXPECT_EQ(last.soles[1].yaw, steps[9].sole.yaw);
  EXPECT_NEAR(last.waist_yaw, 0.5 * (steps[8].sole.yaw + steps[9].sole.yaw), 1e-9);
}

TEST(WalkingPattern, SwingsAsHighAsAsked) {
  const WalkingPattern pattern({}, kFeet, kCom, walk(4));
  double highest = 0;
  for (const PatternTick& t : pattern.ticks())
    highest = std::max({highest, t.soles[0].position.z(), t.soles[1].position.z()});
  EXPECT_NEAR(highest, 0.05, 1e-4);
}

// Halted at `tick`: sound, and what was done by then stays.
WalkingPattern halted(const WalkingPattern& whole, std::size_t tick) {
  WalkingPattern pattern = whole;
  pattern.halt(tick);
  EXPECT_GT(pattern.ticks().size(), tick);
  expect_sound(pattern);
  for (std::size_t k = 0; k <= std::min(tick, pattern.ticks().size() - 1); ++k) EXPECT_EQ(pattern.ticks()[k].com, whole.ticks()[k].com);
  return pattern;
}

TEST(WalkingPattern, HaltsStandingWheneverItIsAsked) {
  const WalkingPattern whole({}, kFeet, kCom, walk(12));
  for (std::size_t tick = 0; tick < whole.ticks().size(); tick += 37) {
    const WalkingPattern pattern = halted(whole, tick);
    if (tick + 900 < whole.ticks().size()) {
      // At most the step under way, the next one, the closing shift of weight and the settling.
      EXPECT_LT(pattern.ticks().size() - tick, 900u);
      EXPECT_LT(pattern.ticks().back().steps_done, 12);
    }
  }
}

// The halt may come later than the end that it would have had.
TEST(WalkingPattern, HaltsInALongDoubleSupport) {
  GaitSettings slow;
  slow.double_support = 4;
  const WalkingPattern whole(slow, kFeet, kCom, walk(3));
  for (std::size_t tick = 0; tick < whole.ticks().size(); tick += 97) halted(whole, tick);
}

TEST(WalkingPattern, RefusesStepsThatDoNotAlternate) {
  EXPECT_THROW(WalkingPattern({}, kFeet, kCom, {{0, kFeet[0]}, {0, kFeet[0]}}), Error);
  EXPECT_THROW(WalkingPattern({}, kFeet, kCom, {{2, kFeet[0]}}), Error);
  GaitSettings s;
  s.single_support = 0;
  EXPECT_THROW(WalkingPattern(s, kFeet, kCom, walk(2)), Error);
}

}  // namespace
}  // namespace periplus::motion
