#include "services/walk_planner/walk_planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::walk {
namespace {

// The room of a demonstration: a table, an obstacle beside it, and the box in which the object is looked for.
FloorSpace demonstration_floor() {
  scene::Scene scene;
  scene.room.size = {6, 6, 2.8};
  scene::Solid table;
  table.name = "table";
  table.size = {0.7, 0.7, 0.7};
  table.X_WS.translation() = Eigen::Vector3d(0, 0, 0.35);
  scene::Solid shelf;
  shelf.name = "shelf";
  shelf.size = {0.4, 0.8, 1.6};
  shelf.X_WS.translation() = Eigen::Vector3d(0.2, 1.2, 0.8);
  scene.solids = {table, shelf};
  const voxel::OccupancyGrid grid(
      voxel::GridGeometry::from_box(make_pose({0, 0, 0.95}, Eigen::Matrix3d::Identity()), {0.55, 0.55, 0.5}, 0.02));
  return FloorSpace(std::make_shared<const scene::CollisionWorld>(scene), {}, &grid, {-3, -3}, {3, 3});
}

TEST(WalkPlanner, WalksAroundTheTableFromViewToView) {
  const FloorSpace floor = demonstration_floor();
  Random random(23);
  int planned = 0;
  for (int n = 0; n < 30; ++n) {
    const auto view = [&random] {
      const double around = random.uniform(-std::numbers::pi, std::numbers::pi), distance = random.uniform(0.8, 1.6);
      return Pose2{distance * std::cos(around), distance * std::sin(around), wrap_angle(around + std::numbers::pi)};
    };
    const Feet start = stance(view(), 0.095), goal = stance(view(), 0.11);
    try {
      const WalkPlan plan = plan_walk(floor, 0.095, start, goal, n);
      ASSERT_GE(plan.steps.size(), 2u);
      Feet feet = start;
      for (const Footstep& s : plan.steps) (s.left ? feet.left : feet.right) = s.sole;
      EXPECT_EQ(feet.left.x, goal.left.x);
      EXPECT_EQ(feet.right.yaw, goal.right.yaw);
      EXPECT_LT(plan.steps.size(), 120u);
      EXPECT_GT(plan.length, 0);
      ++planned;
    } catch (const Error& e) {
      // Only where the shelf stands.
      EXPECT_TRUE(e.code() == ErrorCode::walk_start_in_collision || e.code() == ErrorCode::walk_goal_in_collision)
          << e.what();
    }
  }
  EXPECT_GT(planned, 15);
}

TEST(WalkPlanner, NothingToDo) {
  const Feet feet = stance({1.5, 0, 3}, 0.095);
  const WalkPlan plan = plan_walk(demonstration_floor(), 0.095, feet, feet, 1);
  EXPECT_TRUE(plan.steps.empty());
  EXPECT_EQ(plan.length, 0);
}

}  // namespace
}  // namespace periplus::walk
