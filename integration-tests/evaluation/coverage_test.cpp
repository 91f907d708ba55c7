#include "integration-tests/evaluation/coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"
#include "integration-tests/evaluation/obstacles.h"

namespace periplus::evaluation {
namespace {

constexpr double radius = 0.2;
const Eigen::Vector3d center(0, 0, 1.1);

SurfaceSamples sphere(int n) {
  Random random(3);
  SurfaceSamples s;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d d = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    s.normals.push_back(d);
    s.points.push_back(center + radius * d);
  }
  return s;
}

// The sphere itself.
bool sphere_blocks(const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  const Eigen::Vector3d d = q - p, m = p - center;
  const double a = d.squaredNorm(), b = m.dot(d), c = m.squaredNorm() - radius * radius, disc = b * b - a * c;
  if (disc < 0) return false;
  const double t = (-b - std::sqrt(disc)) / a, u = (-b + std::sqrt(disc)) / a;
  return (t > 0 && t < 1) || (u > 0 && u < 1);
}

TEST(Coverage, EveryPointOfAFreeSphereIsVisibleAndNoneUnderALid) {
  const SurfaceSamples s = sphere(500);
  for (const bool v : visible_samples(s, 200, 75, 1, sphere_blocks)) EXPECT_TRUE(v);
  for (const bool v : visible_samples(s, 50, 75, 1, [](const auto&, const auto&) { return true; })) EXPECT_FALSE(v);
}

// A table right under the sphere, and a cupboard that hides it from one side.
TEST(Coverage, WhatSolidsHideIsNeitherVisibleNorReachable) {
  scene::Scene scene;
  scene::Solid table, cupboard;
  table.size = {1, 1, 0.9};
  table.X_WS.translation() = Eigen::Vector3d(0, 0, 0.45);
  cupboard.size = {0.1, 6, 2.8};
  cupboard.X_WS.translation() = Eigen::Vector3d(0.251, 0, 1.4);  // a millimetre before the sphere, from wall to wall
  scene.solids = {table, cupboard};
  const Obstacles obstacles(scene);
  const SurfaceSamples s = sphere(1000);
  const Blocked blocked = [&](const auto& p, const auto& q) { return sphere_blocks(p, q) || obstacles.block(p, q); };
  const std::vector<bool> visible = visible_samples(s, 200, 75, 1, blocked);
  ReachOptions o;
  o.poses = 1000;
  const StereoRig rig{Pinhole::from_vertical_fov(640, 480, 25 * std::numbers::pi / 180), 0.144};
  const Stands stands = [&](const Pose& X_WC) { return !obstacles.touch_ball(X_WC.translation(), 0.15); };
  const std::vector<bool> reached = reachable_samples(s, rig, reachable_poses(s, o, stands), o, blocked);
  int behind = 0, behind_seen = 0, below = 0, below_seen = 0, before = 0, before_visible = 0, before_reached = 0;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    const Eigen::Vector3d& n = s.normals[i];
    if (n.x() > 0.98) ++behind, behind_seen += visible[i] || reached[i];
    if (n.z() < -0.98) ++below, below_seen += visible[i];
    if (n.x() < -0.9) ++before, before_visible += visible[i], before_reached += reached[i];
  }
  EXPECT_GT(std::min(behind, below), 3);
  EXPECT_EQ(behind_seen, 0);
  EXPECT_EQ(below_seen, 0);
  EXPECT_EQ(before_visible, before);
  EXPECT_GT(before_reached, 0.95 * before);
}

TEST(Coverage, ReachableIsWhatTheIncidenceAllowsFromTheHeightOfTheEyes) {
  const SurfaceSamples s = sphere(2000);
  ReachOptions o;
  o.poses = 2000;
  const StereoRig rig{Pinhole::from_vertical_fov(640, 480, 25 * std::numbers::pi / 180), 0.144};
  const std::vector<Pose> poses = reachable_poses(s, o, [](const Pose&) { return true; });
  ASSERT_EQ(poses.size(), 2000u);
  for (const Pose& X : poses) {
    EXPECT_GE(X.translation().z(), o.height_min);
    EXPECT_LE(X.translation().z(), o.height_max);
    EXPECT_GT((X.translation() - center).norm() - radius, o.distance_min - 0.03);
  }
  const std::vector<bool> reached = reachable_samples(s, rig, poses, o, sphere_blocks);
  int up = 0, up_reached = 0, down_reached = 0, equator = 0, equator_reached = 0;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const double z = s.normals[i].z();
    if (z > 0.97) ++up, up_reached += reached[i];
    if (z < -0.97) down_reached += reached[i];
    if (std::abs(z) < 0.3) ++equator, equator_reached += reached[i];
  }
  EXPECT_EQ(down_reached, 0);                       // eyes above 1.0 m see such normals at over 75 degrees
  EXPECT_GT(equator_reached, 0.99 * equator);
  // The top (z = 1.3) is seen from 1.35 m at >= 0.6 m only at >= 85 degrees.
  EXPECT_LT(up_reached, 0.2 * up);
}

TEST(Coverage, ReachableLiesAtADepthThatThePairMeasures) {
  SurfaceSamples s;  // before one camera that looks along +x from (0, 0, 1.2)
  for (const double x : {0.55, 0.65, 2.45, 2.55}) s.points.emplace_back(x, 0, 1.2);
  s.normals.assign(4, -Eigen::Vector3d::UnitX());
  const StereoRig rig{Pinhole::from_vertical_fov(640, 480, 25 * std::numbers::pi / 180), 0.144};
  const std::vector<bool> reached =
      reachable_samples(s, rig, {look_along({0, 0.072, 1.2}, 0, 0)}, {}, [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return false; });
  EXPECT_EQ(reached, (std::vector<bool>{false, true, true, false}));
}

TEST(Coverage, NobodyStandsInTheObject) {
  SurfaceSamples s;
  s.points = {{1, 2, 0.5}};
  s.normals = {Eigen::Vector3d::UnitZ()};
  const auto at = [](double x, double y, double yaw) { return to_pose({x, y, yaw}) * Pose(Eigen::Translation3d(0, 0, 0.75)); };
  EXPECT_TRUE(box_holds_sample(s, at(1.3, 2, 0), {0.8, 0.2, 1.5}));
  EXPECT_FALSE(box_holds_sample(s, at(1.3, 2, std::numbers::pi / 2), {0.8, 0.2, 1.5}));
  EXPECT_FALSE(box_holds_sample(s, at(1, 2, 0), {0.8, 0.8, 0.4}));
}

TEST(Coverage, NobodyReachesWhatNobodyMayStandAt) {
  const SurfaceSamples s = sphere(100);
  ReachOptions o;
  o.poses = 10;
  EXPECT_TRUE(reachable_poses(s, o, [](const Pose&) { return false; }).empty());
}

TEST(Coverage, CoveredMeansAKnownCentreWithinOneVoxel) {
  SurfaceSamples s;
  s.points = {{0, 0, 0}, {0.0099, 0, 0}, {0.0101, 0, 0}, {-0.008, -0.008, 0}};
  s.normals.assign(4, Eigen::Vector3d::UnitZ());
  const std::vector<bool> covered = covered_samples(s, {.voxel_m = 0.01, .centers = {{0, 0, 0}}});
  EXPECT_EQ(covered, (std::vector<bool>{true, true, false, false}));
  EXPECT_DOUBLE_EQ(share(covered, {true, true, true, false}), 2.0 / 3);
  EXPECT_EQ(share(covered, {false, false, false, false}), 0);
}

TEST(Coverage, Statistics) {
  std::vector<double> d;
  for (int i = 1; i <= 101; ++i) d.push_back(i);
  const ErrorStatistics e = statistics(d);
  EXPECT_DOUBLE_EQ(e.mean, 51);
  EXPECT_DOUBLE_EQ(e.p95, 96);
  EXPECT_DOUBLE_EQ(e.max, 101);
}

std::string npy(const std::string& type, const std::string& data) {
  const std::string dict = "{'descr': '" + type + "'}";
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(dict.size()) + '\0' + dict + data;
}

TEST(Coverage, KnownNeedsThreeDepthPixelsInTheVoxelItself) {
  const std::string folder = testing::TempDir() + "/evaluation_depth";
  std::filesystem::create_directories(folder);
  // Grid of 1 x 1 x 2 voxels of 1 m whose frame is the camera's, shifted so that the axis runs through their middle.
  std::ofstream(folder + "/grid.json") << R"({"voxel_m": 1, "size": [1, 1, 2], "pose_world_grid": [[1,0,0,-0.5],[0,1,0,-0.5],[0,0,1,0],[0,0,0,1]]})";
  std::ofstream(folder + "/grid.npy", std::ios::binary) << npy("|u1", std::string("\2\2", 2));
  std::ofstream(folder + "/look.json") << R"({"rig": {"width": 2, "height": 2, "fx": 10, "fy": 10, "cx": 0.5, "cy": 0.5},
      "pose_world_camera": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]})";
  const auto write_depth = [&](std::vector<float> z) {
    std::ofstream(folder + "/depth.npy", std::ios::binary) << npy("<f4", std::string(reinterpret_cast<const char*>(z.data()), 4 * z.size()));
  };
  const LookGrid grid = read_grid(folder);
  DepthCount count;
  write_depth({0.5f, 0.5f, 1.5f, 0.0f});
  count.add(folder, grid);
  EXPECT_TRUE(count.known(grid).centers.empty());      // two pixels in the near voxel, one in the far one
  write_depth({0.5f, 0.0f, 0.0f, 1.5f});
  count.add(folder, grid);
  ASSERT_EQ(count.known(grid).centers.size(), 1u);     // three and two
  EXPECT_TRUE(count.known(grid).centers[0].isApprox(Eigen::Vector3d(0, 0, 0.5), 1e-12));
  write_depth({0.5f, 0.5f});
  EXPECT_THROW(count.add(folder, grid), Error);
}

// The first look's grid ends before what its depth shows; the second's goes on to it, on the other side of its origin.
TEST(Coverage, AGridThatGrowsCountsTheEarlierLooksAgain) {
  const std::string folder = testing::TempDir() + "/evaluation_growth";
  const auto write_look = [&](const std::string& look, const std::string& grid, const std::string& states) {
    std::filesystem::create_directories(folder + look);
    std::ofstream(folder + look + "/grid.json") << grid;
    std::ofstream(folder + look + "/grid.npy", std::ios::binary) << npy("|u1", states);
    std::ofstream(folder + look + "/look.json") << R"({"rig": {"width": 2, "height": 2, "fx": 10, "fy": 10, "cx": 0.5, "cy": 0.5},
        "pose_world_camera": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]})";
    const float z[4] = {0.5f, 0.5f, 1.5f, 1.5f};
    std::ofstream(folder + look + "/depth.npy", std::ios::binary) << npy("<f4", std::string(reinterpret_cast<const char*>(z), sizeof z));
    return read_grid(folder + look);
  };
  DepthCount count;
  const LookGrid far = write_look("/1", R"({"voxel_m": 1, "size": [1, 1, 1], "pose_world_grid": [[1,0,0,-0.5],[0,1,0,-0.5],[0,0,1,1],[0,0,0,1]]})", "\2");
  count.add(folder + "/1", far);
  EXPECT_TRUE(count.known(far).centers.empty());
  const LookGrid both = write_look("/2", R"({"voxel_m": 1, "size": [1, 1, 2], "pose_world_grid": [[1,0,0,-0.5],[0,1,0,-0.5],[0,0,1,0],[0,0,0,1]]})", std::string("\2\2", 2));
  count.add(folder + "/2", both);
  EXPECT_EQ(count.known(both).centers.size(), 2u);  // two pixels of each look in each voxel
  EXPECT_TRUE(count.known(both, 5).centers.empty());
}

TEST(Coverage, LookThatCannotBeReadIsLeftOutAndNamed) {
  const std::string folder = testing::TempDir() + "/evaluation_looks";
  std::filesystem::remove_all(folder);
  for (const char* look : {"/looks/00", "/looks/01", "/looks/02"}) {
    std::filesystem::create_directories(folder + look);
    std::ofstream(folder + look + "/grid.json") << R"({"voxel_m": 1, "size": [1, 1, 1], "pose_world_grid": [[1,0,0,-0.5],[0,1,0,-0.5],[0,0,1,0],[0,0,0,1]]})";
    std::ofstream(folder + look + "/grid.npy", std::ios::binary) << npy("|u1", "\2");
    std::ofstream(folder + look + "/look.json") << R"({"rig": {"width": 2, "height": 1, "fx": 10, "fy": 10, "cx": 0.5, "cy": 0.5},
        "pose_world_camera": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]})";
    const float z[2] = {0.5f, 0.5f};
    std::ofstream(folder + look + "/depth.npy", std::ios::binary) << npy("<f4", std::string(reinterpret_cast<const char*>(z), sizeof z));
  }
  std::filesystem::remove(folder + "/looks/01/depth.npy");
  SurfaceSamples s;
  s.points = {{0, 0, 0.5}, {5, 0, 0}};
  s.normals.assign(2, Eigen::Vector3d::UnitZ());
  nlohmann::json looks = nlohmann::json::parse(R"([{"look": 0}, {"look": 1}, {"look": 2}])");
  const RunCoverage run = cover_looks(folder, looks, s, {true, false}, {true, true});
  EXPECT_EQ(run.reachable, 1);  // four pixels of two looks
  EXPECT_EQ(run.visible, 0.5);
  ASSERT_EQ(run.skipped.size(), 1u);
  EXPECT_NE(run.skipped[0].find("/looks/01/depth.npy"), std::string::npos) << run.skipped[0];
  EXPECT_EQ(looks[0]["coverage"], 0.0);
  EXPECT_TRUE(looks[1].contains("coverage_error") && !looks[1].contains("coverage"));
  EXPECT_EQ(looks[2]["coverage"], 1.0);
}

TEST(Coverage, DamagedGridFilesAreRefused) {
  const std::string folder = testing::TempDir() + "/evaluation_grid";
  std::filesystem::create_directories(folder);
  EXPECT_THROW(read_grid(folder + "/none"), Error);
  std::ofstream(folder + "/grid.json") << R"({"voxel_m": 0.01, "size": [2, 2, 2], "pose_world_grid": [[1,0,0,5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]})";
  std::ofstream(folder + "/grid.npy", std::ios::binary) << npy("|u1", std::string("\0\1\2\3\0\0\0\2", 8));
  EXPECT_EQ(read_grid(folder).states, (std::vector<std::uint8_t>{0, 1, 2, 3, 0, 0, 0, 2}));
  std::ofstream(folder + "/grid.npy", std::ios::binary) << npy("|u1", "short");
  EXPECT_THROW(read_grid(folder), Error);
  std::ofstream(folder + "/grid.json") << R"({"voxel_m": 0.01, "size": [2, -2, 2]})";
  EXPECT_THROW(read_grid(folder), Error);
}

}  // namespace
}  // namespace periplus::evaluation
