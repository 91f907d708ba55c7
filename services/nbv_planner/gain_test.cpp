#include "services/nbv_planner/gain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "common/core/error.h"
#include "common/mesh/triangle_mesh.h"
#include "common/scene/mesh_solid.h"
#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

using voxel::VoxelState;

constexpr double kUnknown = 0.6931471805599453;  // entropy of p = 0.5 [nat]
const double kKnown = -0.97 * std::log(0.97) - 0.03 * std::log(0.03);
const double kEmpty = -0.12 * std::log(0.12) - 0.88 * std::log(0.88);

// A row of voxels along x, seen along x by a camera of one pixel: one ray through all of them.
Situation row(const std::vector<VoxelState>& states, bool from_the_end = false) {
  Situation s;
  voxel::GridGeometry g;
  g.voxel_size = 0.02;
  g.size = {static_cast<int>(states.size()), 1, 1};
  g.X_WG = make_pose({-0.01 * double(states.size()), -0.01, 1.09}, Eigen::Matrix3d::Identity());
  auto grid = std::make_shared<voxel::OccupancyGrid>(g);
  for (int i = 0; i < g.size.x(); ++i) {
    grid->set_state({from_the_end ? g.size.x() - 1 - i : i, 0, 0}, states[static_cast<std::size_t>(i)]);
  }
  s.grid = grid;
  s.collision = std::make_shared<scene::CollisionWorld>(s.scene);
  s.rig.camera.width = s.rig.camera.height = 1;
  s.rig.camera.fx = s.rig.camera.fy = 100;
  s.rig.baseline = 0;
  return s;
}

std::map<std::string, double> gains(const Situation& s, const Pose& X, GainSettings settings = {}) {
  std::map<std::string, double> by;
  for (const std::string& name : information_gain_names()) {
    const auto gain = make_information_gain(name, s, settings);
    EXPECT_EQ(gain->name(), name);
    by[name] = gain->evaluate(X);
  }
  return by;
}

const Pose kAlongX = look_along({-1, 0, 1.1}, 0, 0);
const GainSettings kEveryPixel{.pixel_step = 1};

TEST(Gain, OneRayThroughUnknownVoxels) {
  const Situation s = row({VoxelState::unknown, VoxelState::unknown, VoxelState::unknown, VoxelState::unknown});
  auto g = gains(s, kAlongX, kEveryPixel);
  const double seen = kUnknown * (1 + 0.5 + 0.25 + 0.125);
  EXPECT_NEAR(g["occlusion_aware"], seen, 1e-12);
  EXPECT_NEAR(g["unobserved"], seen, 1e-12);
  EXPECT_EQ(g["rear_side"], 0);
  EXPECT_EQ(g["rear_side_entropy"], 0);
  EXPECT_EQ(g["proximity_count"], 0);
  EXPECT_EQ(g["average_entropy"], 0);
  EXPECT_EQ(g["area_factor"], 0);
}

TEST(Gain, OneRayUpToTheRearOfASurface) {
  const Situation s = row({VoxelState::empty, VoxelState::empty, VoxelState::unknown, VoxelState::unknown, VoxelState::known,
                           VoxelState::unknown});
  auto g = gains(s, kAlongX, kEveryPixel);
  const double before = 0.88 * 0.88;
  EXPECT_NEAR(g["occlusion_aware"], kEmpty * (1 + 0.88) + before * (kUnknown * 1.5 + kKnown * 0.25), 1e-12);
  EXPECT_NEAR(g["unobserved"], before * kUnknown * 1.5, 1e-12);
  EXPECT_EQ(g["rear_side"], 1);
  EXPECT_NEAR(g["rear_side_entropy"], before * (kUnknown * 1.5 + kKnown * 0.25), 1e-12);
  EXPECT_NEAR(g["proximity_count"], (10 - 2) + (10 - 1), 1e-6);  // what lies behind the surface is not reached
  EXPECT_NEAR(g["average_entropy"], (2 * kEmpty + 2 * kUnknown + kKnown) / 5, 1e-12);
  EXPECT_NEAR(g["area_factor"], 0, 1e-12);  // all rays on the occlusion plane: as little as none
}

TEST(Gain, FrontOfASurfaceIsNoRearSide) {
  const Situation s = row({VoxelState::empty, VoxelState::known, VoxelState::unknown});
  auto g = gains(s, kAlongX, kEveryPixel);
  EXPECT_EQ(g["rear_side"], 0);
  EXPECT_EQ(g["rear_side_entropy"], 0);
  EXPECT_EQ(g["unobserved"], 0);
  EXPECT_NEAR(g["average_entropy"], (kEmpty + kKnown) / 2, 1e-12);
  // Unknown, then empty again, then surface: its front was seen through the gap.
  auto gap = gains(row({VoxelState::unknown, VoxelState::empty, VoxelState::known}), kAlongX, kEveryPixel);
  EXPECT_EQ(gap["rear_side"], 0);
  EXPECT_EQ(gap["rear_side_entropy"], 0);
}

TEST(Gain, AreaFactorIsGreatestAtTheDesiredShares) {
  // A wall of 10 x 10 voxels that fills the image; `unknown` columns of it are unknown and stand before an empty layer.
  const auto wall = [](int unknown) {
    Situation s = row({VoxelState::empty});
    voxel::GridGeometry g;
    g.voxel_size = 0.1;
    g.size = {2, 10, 10};
    g.X_WG = make_pose({0, -0.5, 0.6}, Eigen::Matrix3d::Identity());
    auto grid = std::make_shared<voxel::OccupancyGrid>(g);
    for (int y = 0; y < 10; ++y) {
      for (int z = 0; z < 10; ++z) {
        grid->set_state({0, y, z}, VoxelState::empty);
        grid->set_state({1, y, z}, y < unknown ? VoxelState::unknown : VoxelState::known);
      }
    }
    s.grid = grid;
    s.rig.camera.width = s.rig.camera.height = 20;
    s.rig.camera.cx = s.rig.camera.cy = 9.5;
    s.rig.camera.fx = s.rig.camera.fy = 22;  // 0.1 m voxels at 1.1 m: two pixels each
    return s;
  };
  std::map<int, double> by;
  for (int unknown : {0, 4, 8, 10}) {
    const Situation s = wall(unknown);
    by[unknown] = make_information_gain("area_factor", s, kEveryPixel)->evaluate(kAlongX);
  }
  EXPECT_NEAR(by[8], 2, 1e-9);
  EXPECT_NEAR(by[4], 0.5 + 0.5, 1e-9);  // both half-way to their desired shares
  EXPECT_NEAR(by[0], 0, 1e-9);
  EXPECT_NEAR(by[10], 0, 1e-9);
}

TEST(Gain, SolidsAndEnvironmentEndARay) {
  Situation s = row({VoxelState::environment, VoxelState::unknown});
  EXPECT_EQ(make_information_gain("unobserved", s, kEveryPixel)->evaluate(kAlongX), 0);
  s = row({VoxelState::unknown});
  EXPECT_NEAR(make_information_gain("unobserved", s, kEveryPixel)->evaluate(kAlongX), kUnknown, 1e-12);
  for (scene::Shape shape : {scene::Shape::box, scene::Shape::cylinder, scene::Shape::sphere}) {
    scene::Solid solid = testing::box({-0.5, 0, 1.1}, {0.2, 0.2, 0.2});
    solid.shape = shape;
    const auto unobserved = [&] {
      s.scene.solids = {solid};
      s.collision = std::make_shared<scene::CollisionWorld>(s.scene);
      return make_information_gain("unobserved", s, kEveryPixel)->evaluate(kAlongX);
    };
    EXPECT_EQ(unobserved(), 0);
    solid.X_WS.translation().y() = 0.11;  // beside the ray
    EXPECT_NEAR(unobserved(), kUnknown, 1e-12);
    solid.X_WS.translation() = Eigen::Vector3d(0.2, 0, 1.1);  // behind the voxel
    EXPECT_NEAR(unobserved(), kUnknown, 1e-12);
  }
}

// A wall of a mesh, closed or a single skin, between the eyes and what they would see.
TEST(Gain, MeshWallsHideWhatIsBehindThem) {
  mesh::TriangleMesh skin;
  skin.vertices = {{0, -0.6, -0.6}, {0, 0.6, -0.6}, {0, 0.6, 0.6}, {0, -0.6, 0.6}};
  skin.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (const mesh::TriangleMesh& wall : {mesh::make_box({0.05, 1.2, 1.2}, 1), skin}) {
    scene::Solid solid;
    solid.shape = scene::Shape::mesh;
    solid.mesh = std::make_shared<const scene::MeshSolid>(wall);
    solid.size = solid.mesh->size();
    solid.X_WS = make_pose({0.6, 0, 1.1}, Eigen::Matrix3d::Identity());
    scene::Scene scene;
    scene.room.size = {8, 8, 3};
    const Pose front = look_along({1.3, -0.072, 1.1}, std::numbers::pi, 0);
    const auto free = gains(testing::patch_at_plus_x(scene), front);
    scene.solids = {solid};
    const Situation walled = testing::patch_at_plus_x(scene);
    for (const auto& [name, gain] : gains(walled, front)) {
      EXPECT_EQ(gain, 0) << name;
      if (name != "area_factor") {
        EXPECT_GT(free.at(name), 0) << name;
      }
    }
    const Evaluator evaluator(walled, {}, {});
    Evaluator::Workspace w;
    EXPECT_EQ(evaluator.evaluate(front, w).gain.voxels, 0);
    // Past the wall's end.
    const Pose beside = look_at({0.75, 1.3, 1.1}, {0.15, 0, 1.1});
    EXPECT_GT(make_information_gain("unobserved", walled)->evaluate(beside), 0);
  }
}

TEST(Gain, TheUnknownFaceIsWhereAllButTheRearSideLook) {
  // A block known but for its face at +x: from there all unknown is seen; from -x nothing that is unknown.
  const Situation s = testing::patch_at_plus_x();
  const Pose front = look_along({1.3, -0.072, 1.1}, std::numbers::pi, 0), back = look_along({-1.3, 0.072, 1.1}, 0, 0);
  auto at_front = gains(s, front), at_back = gains(s, back);
  for (const char* name : {"unobserved", "rear_side", "rear_side_entropy", "proximity_count"}) {
    EXPECT_GT(at_front[name], 0) << name;
    EXPECT_EQ(at_back[name], 0) << name;
  }
  EXPECT_GT(at_front["occlusion_aware"], at_back["occlusion_aware"]);
  EXPECT_GT(at_front["average_entropy"], at_back["average_entropy"]);
  // 15 voxels fill (1082.6 * 0.3 / 1.15) pixels: so many rays, one of eight each way, meet unknown and then known.
  const double rays = std::pow(s.rig.camera.fx * 0.3 / 1.15 / 8, 2);
  EXPECT_NEAR(at_front["rear_side"], rays, 0.1 * rays);
}

TEST(Gain, BadOnesAreRefused) {
  const Situation s = row({VoxelState::unknown});
  EXPECT_THROW(make_information_gain("entropy", s), Error);
  EXPECT_THROW(make_information_gain("unobserved", s, {.pixel_step = 0}), Error);
  EXPECT_THROW(make_information_gain("unobserved", s, {.p_unknown = 1}), Error);
  Pose X = kAlongX;
  X.translation().x() = std::nan("");
  EXPECT_THROW(make_information_gain("unobserved", s)->evaluate(X), Error);
}

}  // namespace
}  // namespace periplus::nbv
