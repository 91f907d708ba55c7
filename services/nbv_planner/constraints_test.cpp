#include "services/nbv_planner/constraints.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Fixture {
  explicit Fixture(Situation s) : situation(std::move(s)), scene(*situation.grid), constraints(situation, scene, {}) {}
  Violation at(double x, double y, double z, double yaw_deg = 180, double pitch_deg = 0, double roll_deg = 0) const {
    return constraints.check(look_along({x, y, z}, yaw_deg * kDegree, pitch_deg * kDegree, roll_deg * kDegree));
  }
  Situation situation;
  voxel::VisibilityScene scene;
  Constraints constraints;
};

TEST(Constraints, NearestVoxelIsTheNearestCentre) {
  Random random(3);
  const Situation s = testing::around_the_origin(20, [&](int, int, int) {
    return random.uniform() < 0.02 ? voxel::VoxelState::known : voxel::VoxelState::empty;
  });
  const voxel::VisibilityScene scene(*s.grid);
  const Constraints constraints(s, scene, {});
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0, 2));
    double least = std::numeric_limits<double>::infinity();
    for (int x = 0; x < 20; ++x) {
      for (int y = 0; y < 20; ++y) {
        for (int z = 0; z < 20; ++z) {
          if (s.grid->state({x, y, z}) == voxel::VoxelState::empty) continue;
          least = std::min(least, (s.grid->geometry().center_world({x, y, z}) - p).norm());
        }
      }
    }
    EXPECT_NEAR(constraints.nearest_voxel(p), least, 1e-9);
  }
}

TEST(Constraints, EachLimitIsNamed) {
  const Fixture f(testing::patch_at_plus_x());
  EXPECT_EQ(f.at(1.2, 0, 1.1), Violation::none);
  EXPECT_EQ(f.at(1.2, 0, 0.99), Violation::height);
  EXPECT_EQ(f.at(1.2, 0, 1.36), Violation::height);
  EXPECT_EQ(f.at(1.2, 0, 1.1, 180, 61), Violation::pitch);
  EXPECT_EQ(f.at(1.2, 0, 1.1, 180, -26), Violation::pitch);
  EXPECT_EQ(f.at(1.2, 0, 1.1, 180, 0, 1), Violation::roll);
  EXPECT_EQ(f.at(0.70, 0, 1.1), Violation::too_near);   // the face's centres are at 0.14
  EXPECT_EQ(f.at(0.76, 0, 1.1), Violation::none);
  EXPECT_EQ(f.at(2.66, 0, 1.1), Violation::too_far);
  EXPECT_EQ(f.at(2.9, 0, 1.1), Violation::room);        // walls at 3 m
  EXPECT_EQ(f.constraints.check(look_along({std::nan(""), 0, 1.1}, 0, 0)), Violation::not_finite);
}

TEST(Constraints, HeadAndBodyKeepClearOfSolids) {
  scene::Scene scene;
  scene.solids.push_back(testing::box({1.2, 0.6, 1.1}, {0.2, 0.2, 0.4}));   // hangs at head height
  scene.solids.push_back(testing::box({1.3, -0.7, 0.2}, {0.2, 0.2, 0.4}));  // stands on the floor
  const Fixture f(testing::patch_at_plus_x(scene));
  EXPECT_EQ(f.at(1.2, 0.6, 1.1), Violation::head);
  EXPECT_EQ(f.at(1.2, 0.39, 1.1), Violation::head);   // the left eye 0.11 m from its side
  EXPECT_EQ(f.at(1.2, -0.7, 1.1), Violation::body);   // the base would stand in it
  EXPECT_EQ(f.at(1.2, 0, 1.1), Violation::none);
}

TEST(Constraints, BodyKeepsOutOfTheObject) {
  // A low plate of voxels at the waist, below the eyes by more than the least distance.
  const auto plate = [](int, int, int z) { return z == 0 ? voxel::VoxelState::known : voxel::VoxelState::empty; };
  Situation s = testing::around_the_origin(30, plate);
  auto grid = std::make_shared<voxel::OccupancyGrid>(*s.grid);
  voxel::GridGeometry g = grid->geometry();
  g.X_WG.translation().z() = 0.5;
  voxel::OccupancyGrid low(g);
  low.adopt(grid->occupied(), grid->known(), grid->environment());
  s.grid = std::make_shared<voxel::OccupancyGrid>(low);
  const Fixture f(s);
  EXPECT_EQ(f.at(0.4, 0, 1.3), Violation::body);
  EXPECT_EQ(f.at(0.6, 0, 1.3), Violation::none);

  // On the floor the whole box of the object is closed, empty voxels too.
  g.X_WG.translation().z() = 0;
  voxel::OccupancyGrid floor(g);
  floor.set_state({0, 0, 0}, voxel::VoxelState::known);
  for (auto& w : floor.occupied()) w = 0;
  floor.set_state({0, 0, 0}, voxel::VoxelState::known);
  s.grid = std::make_shared<voxel::OccupancyGrid>(floor);
  const Fixture on_floor(s);
  EXPECT_EQ(on_floor.at(0.35, 0.2, 1.3), Violation::body);
  EXPECT_EQ(on_floor.at(0.6, 0.2, 1.3), Violation::none);
}

TEST(Constraints, ForbiddenNeedsBothPlaceAndDirection) {
  Situation s = testing::patch_at_plus_x();
  s.forbidden.push_back(look_along({1.2, 0, 1.1}, std::numbers::pi, 0.1));
  const Fixture f(s);
  EXPECT_EQ(f.at(1.2, 0.05, 1.1, 185, 6), Violation::forbidden);
  EXPECT_EQ(f.at(1.2, 0.099, 1.1, 180, 5.7), Violation::forbidden);
  EXPECT_EQ(f.at(1.2, 0.11, 1.1, 180, 5.7), Violation::none);
  EXPECT_EQ(f.at(1.2, 0.05, 1.1, 192, 5.7), Violation::none);
}

TEST(Constraints, PositionAloneIsCheckedAlike) {
  const Fixture f(testing::patch_at_plus_x());
  EXPECT_EQ(f.constraints.check_position({1.2, 0, 1.1}, std::numbers::pi), Violation::none);
  EXPECT_EQ(f.constraints.check_position({0.7, 0, 1.1}, std::numbers::pi), Violation::too_near);
  EXPECT_EQ(f.constraints.check_position({1.2, 0, 1.4}, std::numbers::pi), Violation::height);
  EXPECT_EQ(f.constraints.check_position({2.9, 0, 1.1}, std::numbers::pi), Violation::room);
  EXPECT_STREQ(to_string(Violation::too_near), "too near to the object");
}

}  // namespace
}  // namespace periplus::nbv
