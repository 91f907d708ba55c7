#include "services/walk_planner/walk_planner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/object_model/growth.h"
#include "common/object_model/testing/sphere_views.h"

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

// A ball whose box has grown so far that the robot, who looked at it from there, stands within: the new corner was seen by no view.
class GrownBox : public ::testing::Test {
 protected:
  void SetUp() override {
    using namespace object_model;
    ObjectBox box = object_model::testing::box_around(ball, 0.9);
    box.X_WB.translation().x() -= 0.4;  // ends at the ball's middle
    ObjectModel model("ball", box, 0.05, {});
    for (int n = 0; n < 6; ++n) model.integrate(object_model::testing::ideal_view(ball, n, 6), {}, {});
    Growth growth = grow(model, {}, {}, {.least_voxels = 4, .margin_voxels = 4, .least_area = 0.01});
    ASSERT_TRUE(growth.model.has_value()) << growth.refused;
    begun = model.grid();
    grown = growth.model->grid();
  }
  FloorSpace floor(const voxel::OccupancyGrid& grid) const {
    scene::Scene scene;
    scene.room.size = {8, 8, 2.8};
    return FloorSpace(std::make_shared<const scene::CollisionWorld>(scene), {}, &grid, {-4, -4}, {4, 4});
  }
  const object_model::testing::Sphere ball;
  voxel::OccupancyGrid begun, grown;
};

TEST_F(GrownBox, IsLeftByTheRobotWhoStandsInItsCorner) {
  const Feet start = stance({0.5, 0.45, -2.4}, 0.095), goal = stance({1.3, -1.3, 2.4}, 0.095);
  const WalkSettings settings;
  const double shrink = settings.path.end_shrink;
  ASSERT_EQ(floor(begun).blocked(middle(start), shrink), Blocked::no);
  ASSERT_EQ(floor(grown).blocked(middle(start), shrink), Blocked::by_object);
  const WalkPlan plan = plan_walk(floor(grown), 0.095, start, goal, 3, settings);
  EXPECT_GE(plan.steps.size(), 2u);

  // No voxel that may be the object's is in the robot's way but those that it stood in: by their centres, looked at finely.
  const robot::BodyBox body;
  const auto within = [&](const Pose2& at, const Eigen::Vector3d& p_W, double outwards) {
    const Pose2 p = compose(inverse(at), {p_W.x(), p_W.y(), 0});
    return p.x > body.lower.x() + shrink - outwards && p.x < body.upper.x() - shrink + outwards && p.y > body.lower.y() + shrink - outwards &&
           p.y < body.upper.y() - shrink + outwards && p_W.z() < body.upper.z();
  };
  int stood_in = 0;
  object_model::testing::for_each_voxel(grown.geometry(), [&](const Eigen::Vector3i& v) {
    if (grown.state(v) == voxel::VoxelState::empty) return;
    const Eigen::Vector3d p_W = grown.geometry().center_world(v);
    if (within(middle(start), p_W, 0)) {
      EXPECT_EQ(grown.state(v), voxel::VoxelState::unknown);
      ++stood_in;
    }
    if (within(middle(start), p_W, 2 * grown.geometry().voxel_size)) return;
    for (std::size_t i = 0; i + 1 < plan.path.size(); ++i)
      for (int k = 0; k <= 50; ++k) ASSERT_FALSE(within(interpolate(plan.path[i], plan.path[i + 1], k / 50.0), p_W, 0)) << p_W.transpose();
  });
  EXPECT_GT(stood_in, 10);
}

TEST_F(GrownBox, IsNotLeftThroughWhatIsTheObjects) {
  const Feet start = stance({0.5, 0.45, -2.4}, 0.095), goal = stance({1.3, -1.3, 2.4}, 0.095);
  grown.set_state(grown.geometry().voxel_of({0.43, 0.38, 1.0}), voxel::VoxelState::known);
  try {
    plan_walk(floor(grown), 0.095, start, goal, 3);
    FAIL() << "a known voxel is where the robot stands";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::walk_start_in_collision) << e.what();
  }
}

// What is freed where a robot stands is covered by the robot: its shadow on the floor.
TEST(WalkPlanner, TheBoxMovedInwardsIsTheRobotsOwn) {
  const auto robot = robot::RobotModel::load_files(std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/hrp2like.urdf", std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/hrp2like.yaml");
  robot::Kinematics kinematics(robot);
  kinematics.set(robot->half_sitting());
  const robot::BodyBox& body = robot->body_box();
  const double shrink = WalkSettings{}.path.end_shrink;
  double outside = -1;
  for (double x = body.lower.x() + shrink; x <= body.upper.x() - shrink; x += 0.01)
    for (double y = body.lower.y() + shrink; y <= body.upper.y() - shrink; y += 0.01) {
      double nearest = 1;
      for (std::size_t i = 0; i < robot->capsules().size(); ++i) {
        Eigen::Vector3d a, b;
        kinematics.capsule(static_cast<int>(i), a, b);
        const Eigen::Vector2d d = (b - a).head<2>(), p = Eigen::Vector2d(x, y) - a.head<2>();
        const double t = d.squaredNorm() > 0 ? std::clamp(p.dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
        nearest = std::min(nearest, (p - t * d).norm() - robot->capsules()[i].radius);
      }
      outside = std::max(outside, nearest);
    }
  EXPECT_LT(outside, 0.04);  // behind the upper arms
}

TEST(WalkPlanner, NothingToDo) {
  const Feet feet = stance({1.5, 0, 3}, 0.095);
  const WalkPlan plan = plan_walk(demonstration_floor(), 0.095, feet, feet, 1);
  EXPECT_TRUE(plan.steps.empty());
  EXPECT_EQ(plan.length, 0);
}

}  // namespace
}  // namespace periplus::walk
