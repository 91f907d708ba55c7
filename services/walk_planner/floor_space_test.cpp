#include "services/walk_planner/floor_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::walk {
namespace {

std::shared_ptr<const scene::CollisionWorld> room_with(std::vector<scene::Solid> solids) {
  scene::Scene scene;
  scene.room.size = {6, 6, 2.8};
  scene.solids = std::move(solids);
  return std::make_shared<const scene::CollisionWorld>(scene);
}

scene::Solid box(const Eigen::Vector3d& size, const Eigen::Vector3d& center) {
  scene::Solid s;
  s.name = "box";
  s.size = size;
  s.X_WS.translation() = center;
  return s;
}

TEST(FloorSpace, SolidsAndWallsBlock) {
  const FloorSpace floor(room_with({box({0.4, 0.4, 0.7}, {1, 0, 0.35})}), {}, nullptr, {-3, -3}, {3, 3});
  EXPECT_EQ(floor.blocked({0, 0, 0}), Blocked::no);
  EXPECT_EQ(floor.blocked({0.6, 0, 0}), Blocked::by_scene);
  EXPECT_EQ(floor.blocked({-2.9, 0, 0}), Blocked::by_scene);
  // Sides of the box: 0.25 ahead, 0.35 to the left; the solid's face stands at x = 0.8.
  EXPECT_EQ(floor.blocked({0.54, 0, 0}), Blocked::no);
  EXPECT_EQ(floor.blocked({0.54, 0, std::numbers::pi / 2}), Blocked::by_scene);
  EXPECT_EQ(floor.blocked({0.54, 0, std::numbers::pi / 2}, 0.1), Blocked::no);
}

TEST(FloorSpace, ObjectBlocksAsItsVoxelsDo) {
  const Pose X_WB = make_pose({0.2, -0.1, 0.9}, rotation_from_yaw_pitch_roll(0.4, 0, 0));
  voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(X_WB, {0.5, 0.3, 0.4}, 0.02));
  const Eigen::Vector3i size = grid.geometry().size;
  Random random(5);
  for (int i = 0; i < size.x(); ++i)
    for (int j = 0; j < size.y(); ++j)
      for (int k = 0; k < size.z(); ++k) {
        if (i > size.x() / 2) grid.set_state({i, j, k}, voxel::VoxelState::empty);
        if (i <= 2) grid.set_state({i, j, k}, voxel::VoxelState::environment);
      }
  const robot::BodyBox body;
  const FloorSpace floor(room_with({}), body, &grid, {-3, -3}, {3, 3});
  int touching = 0;
  for (int n = 0; n < 400; ++n) {
    const Pose2 p{random.uniform(-1, 1.4), random.uniform(-1.2, 1), random.uniform(-3, 3)};
    // Signed distance of the nearest blocking voxel's centre to the rectangle.
    double nearest = 1e9;
    for (int i = 0; i < size.x(); ++i)
      for (int j = 0; j < size.y(); ++j) {
        if (grid.state({i, j, 0}) != voxel::VoxelState::unknown) continue;
        const Eigen::Vector3d c = grid.geometry().center_world({i, j, 0});
        const Pose2 in_body = compose(inverse(p), {c.x(), c.y(), 0});
        nearest = std::min(
            nearest, std::hypot(std::max(std::abs(in_body.x) - 0.25, 0.0), std::max(std::abs(in_body.y) - 0.35, 0.0)));
      }
    const bool blocked = floor.blocked(p) == Blocked::by_object;
    if (nearest < 0.01) {
      EXPECT_TRUE(blocked) << p.x << " " << p.y;
    }
    if (nearest > 0.04) {
      EXPECT_FALSE(blocked) << p.x << " " << p.y;
    }
    touching += blocked;
  }
  EXPECT_GT(touching, 20);
}

TEST(FloorSpace, AnObjectAboveTheHeadDoesNotBlock) {
  voxel::OccupancyGrid grid(
      voxel::GridGeometry::from_box(make_pose({0, 0, 2.2}, Eigen::Matrix3d::Identity()), {0.4, 0.4, 0.4}, 0.05));
  const FloorSpace floor(room_with({}), {}, &grid, {-3, -3}, {3, 3});
  EXPECT_EQ(floor.blocked({0, 0, 0}), Blocked::no);
}

// Voxels of 5 cm over all of the floor within half a metre, none of which anybody has looked at.
voxel::OccupancyGrid unseen() {
  return voxel::OccupancyGrid(voxel::GridGeometry::from_box(make_pose({0, 0, 0.5}, Eigen::Matrix3d::Identity()), {1, 1, 1}, 0.05));
}

TEST(FloorSpace, NoObjectIsWhereTheRobotStands) {
  const voxel::OccupancyGrid grid = unseen();
  const FloorSpace before(room_with({}), {}, &grid, {-3, -3}, {3, 3});
  const Pose2 here{0.1, -0.05, 0.4};
  EXPECT_EQ(before.blocked(here, 0.1), Blocked::by_object);
  const FloorSpace floor = before.left_from(here, 0.1);
  EXPECT_EQ(floor.blocked(here, 0.1), Blocked::no);
  // Nothing is freed but what the robot covers: a side of the box moved outwards by a voxel touches again, and so it is a step further on.
  EXPECT_EQ(floor.blocked(here, 0.1 - 0.05), Blocked::by_object);
  for (const double turn : {-2.5, -1.2, 0.0, 0.9, 2.0}) {
    const Pose2 aside{here.x + 0.1 * std::cos(turn), here.y + 0.1 * std::sin(turn), here.yaw};
    EXPECT_EQ(floor.blocked(aside, 0.1), Blocked::by_object) << turn;
  }
  EXPECT_EQ(before.blocked(here, 0.1), Blocked::by_object);
}

TEST(FloorSpace, WhatDepthHasShownIsLeftWhereTheRobotStandsToo) {
  voxel::OccupancyGrid grid = unseen();
  const FloorSpace unknown(room_with({}), {}, &grid, {-3, -3}, {3, 3});
  EXPECT_EQ(unknown.left_from({}, 0.1).blocked({}, 0.1), Blocked::no);
  grid.set_state({10, 10, 15}, voxel::VoxelState::known);  // one, above all others of its column that are not
  const FloorSpace seen(room_with({}), {}, &grid, {-3, -3}, {3, 3});
  EXPECT_EQ(seen.left_from({}, 0.1).blocked({}, 0.1), Blocked::by_object);
}

TEST(FloorSpace, EmptyFloorIsRefused) { EXPECT_THROW(FloorSpace(room_with({}), {}, nullptr, {1, 0}, {0, 1}), Error); }

}  // namespace
}  // namespace periplus::walk
