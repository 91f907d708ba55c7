#include "services/walk_planner/path_planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::walk {
namespace {

scene::Solid box_at(const Eigen::Vector3d& size, const Eigen::Vector3d& center) {
  scene::Solid s;
  s.name = "box";
  s.size = size;
  s.X_WS.translation() = center;
  return s;
}

FloorSpace floor_with(std::vector<scene::Solid> solids) {
  scene::Scene scene;
  scene.room.size = {6, 6, 2.8};
  scene.solids = std::move(solids);
  return FloorSpace(std::make_shared<const scene::CollisionWorld>(scene), {}, nullptr, {-3, -3}, {3, 3});
}

// Every pose of the path, much finer than the planner looks.
void expect_free(const FloorSpace& floor, const Path& path, const PathSettings& s) {
  const Pose2 start = path.poses.front(), goal = path.poses.back();
  for (std::size_t i = 0; i + 1 < path.poses.size(); ++i)
    for (int k = 0; k <= 200; ++k) {
      const Pose2 p = interpolate(path.poses[i], path.poses[i + 1], k / 200.0);
      const double to_end = std::min(std::hypot(p.x - start.x, p.y - start.y), std::hypot(p.x - goal.x, p.y - goal.y));
      // Half the distance between checked poses, and what a turn in between swings a corner, may be overlooked.
      const double overlooked = 0.5 * s.check_distance + 0.5 * s.check_angle * 0.43;
      EXPECT_EQ(floor.blocked(p, overlooked + (to_end <= s.end_radius + 0.02 ? s.end_shrink : 0)), Blocked::no)
          << p.x << " " << p.y;
    }
}

ErrorCode refusal(const FloorSpace& floor, const Pose2& start, const Pose2& goal, const PathSettings& s = {}) {
  try {
    plan_path(floor, start, goal, 1, s);
  } catch (const Error& e) {
    return e.code();
  }
  return ErrorCode::ok;
}

TEST(PathPlanner, GoesAroundAWall) {
  const FloorSpace floor = floor_with({box_at({0.2, 4.0, 1.8}, {0, -1, 0.9})});
  const Path path = plan_path(floor, {-1.5, -1.5, 0}, {1.5, -1.5, 0}, 7);
  EXPECT_EQ(path.poses.front().x, -1.5);
  EXPECT_EQ(path.poses.back().x, 1.5);
  EXPECT_GT(path.length(), 5.0);  // over y = 1 + 0.25 and back
  EXPECT_LT(path.length(), 9.0);
  EXPECT_GT(path.samples, 0);
  expect_free(floor, path, {});
}

TEST(PathPlanner, FacesTheWayWhenItIsLong) {
  const Path path = plan_path(floor_with({}), {-2, 0, 1.57}, {2, 0, 1.57}, 1);
  ASSERT_EQ(path.poses.size(), 4u);
  EXPECT_NEAR(path.poses[1].yaw, 0, 1e-9);
  EXPECT_NEAR(path.length(), 4, 1e-9);
}

TEST(PathPlanner, SideStepsWhenItIsShort) {
  EXPECT_EQ(plan_path(floor_with({}), {0, 0, 0}, {0, 0.1, 0}, 1).poses.size(), 2u);
}

TEST(PathPlanner, TellsWhyThereIsNoPath) {
  PathSettings quick;
  quick.samples = 600;
  const std::vector<scene::Solid> cell{box_at({2, 0.1, 2}, {1, 1, 1}), box_at({2, 0.1, 2}, {1, -1, 1}),
                                       box_at({0.1, 2, 2}, {0, 0, 1}), box_at({0.1, 2, 2}, {2, 0, 1})};
  EXPECT_EQ(refusal(floor_with(cell), {-2, 0, 0}, {1, 0, 0}, quick), ErrorCode::walk_no_path);
  const std::vector<scene::Solid> pillar{box_at({0.5, 0.5, 2}, {1, 0, 1})};
  EXPECT_EQ(refusal(floor_with(pillar), {-2, 0, 0}, {1, 0, 0}), ErrorCode::walk_goal_in_collision);
  EXPECT_EQ(refusal(floor_with(pillar), {1, 0, 0}, {-2, 0, 0}), ErrorCode::walk_start_in_collision);
}

TEST(PathPlanner, StandsNearATable) {
  // The box would touch the table's edge at the goal, the robot itself does not.
  const FloorSpace floor = floor_with({box_at({0.7, 0.7, 0.7}, {0, 0, 0.35})});
  EXPECT_EQ(floor.blocked({-0.55, 0, 0}), Blocked::by_scene);
  EXPECT_EQ(refusal(floor, {-2, 0, 0}, {-0.55, 0, 0}), ErrorCode::ok);
}

TEST(PathPlanner, RandomRoomsGiveFreePathsAndTheSameOnesAgain) {
  Random random(11);
  int found = 0, refused = 0;
  for (int n = 0; n < 25; ++n) {
    std::vector<scene::Solid> solids;
    for (int k = 0; k < 5; ++k)
      solids.push_back(box_at({random.uniform(0.2, 1), random.uniform(0.2, 1), 1.5},
                           {random.uniform(-2, 2), random.uniform(-2, 2), 0.75}));
    const FloorSpace floor = floor_with(solids);
    const auto pose = [&random] {
      return Pose2{random.uniform(-2.5, 2.5), random.uniform(-2.5, 2.5), random.uniform(-3.1, 3.1)};
    };
    const Pose2 start = pose(), goal = pose();
    try {
      const Path path = plan_path(floor, start, goal, 100 + n);
      expect_free(floor, path, {});
      EXPECT_EQ(path.poses.front().yaw, start.yaw);
      EXPECT_NEAR(path.poses.back().x, goal.x, 1e-12);
      EXPECT_NEAR(path.poses.back().yaw, goal.yaw, 1e-12);
      const Path again = plan_path(floor, start, goal, 100 + n);
      ASSERT_EQ(again.poses.size(), path.poses.size());
      for (std::size_t i = 0; i < path.poses.size(); ++i) {
        EXPECT_EQ(again.poses[i].x, path.poses[i].x);
        EXPECT_EQ(again.poses[i].yaw, path.poses[i].yaw);
      }
      ++found;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(found, 8);
  EXPECT_GT(refused, 2);
}

TEST(PathPlanner, BadSettingsAreRefused) {
  PathSettings s;
  s.check_distance = 0;
  EXPECT_EQ(refusal(floor_with({}), {0, 0, 0}, {1, 0, 0}, s), ErrorCode::bad_input);
}

}  // namespace
}  // namespace periplus::walk
