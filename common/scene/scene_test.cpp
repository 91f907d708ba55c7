#include "common/scene/scene.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>

#include "common/core/error.h"
#include "common/mesh/triangle_mesh.h"
#include "common/scene/mesh_solid.h"

namespace periplus::scene {
namespace {

const char* const kText = R"(schema: periplus-scene-1
name: kitchen
room: {size_m: [5, 4, 2.5], wall_texture: "noise:3", floor_texture: floor.png}
solids:
  - {name: table, size_m: [0.7, 0.7, 0.7], position_m: [0, 0, 0.35], supports_object: true}
  - {name: pillar, shape: cylinder, diameter_m: 0.3, height_m: 2, position_m: [1, 0.5, 1], yaw_deg: 90, rgb: [1, 0, 0]}
lights:
  - {position_m: [0, 0, 2.4], intensity: 0.5}
landmarks:
  - {name: mark, position_m: [2.5, 0, 1], normal: [-2, 0, 0], size_m: 0.2}
robot_start: {x_m: -1.5, y_m: 0.25, yaw_deg: 90}
# What only a simulator knows.
truth:
  mesh: bunny.obj
  longest_side_m: 0.45
  up_axis: y
  position_m: [0, 0, 0.7]
  texture: noise:5
)";

std::string message_of(const std::string& text) {
  try {
    parse_scene(text, "s.yaml");
  } catch (const Error& e) {
    EXPECT_NE(e.code(), ErrorCode::internal);
    return e.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

TEST(Scene, ImperfectionsOfCamerasAreReadAndChecked) {
  const auto with = [](const std::string& cameras) { return std::string(kText) + "cameras: {" + cameras + "}\n"; };
  const CameraImperfections none = parse_scene(kText, "s.yaml").cameras;
  EXPECT_FALSE(none.noise || none.right_gain || none.right_offset);
  EXPECT_TRUE(none.left_distortion.empty() && none.right_distortion.empty() && none.wide_distortion.empty());
  const CameraImperfections c =
      parse_scene(with("noise_grey: 3, right_gain: 0.9, right_offset_grey: -4, left_distortion: [-0.2, 0.05, 0, 0.001, 0], wide_distortion: []"), "s.yaml").cameras;
  EXPECT_EQ(c.noise, 3);
  EXPECT_EQ(c.right_gain, 0.9);
  EXPECT_EQ(c.right_offset, -4);
  EXPECT_EQ(c.left_distortion, (std::vector<double>{-0.2, 0.05, 0, 0.001, 0}));
  EXPECT_TRUE(c.right_distortion.empty());
  for (const char* bad : {"noise_grey: -1", "right_gain: 0", "left_distortion: [1, 2]", "right_distortion: [.nan, 0, 0, 0, 0]", "gain: 2"})
    EXPECT_THROW(parse_scene(with(bad), "s.yaml"), Error) << bad;
}

TEST(Scene, ReadsEverything) {
  const Scene s = parse_scene(kText, "s.yaml");
  EXPECT_EQ(s.name, "kitchen");
  EXPECT_EQ(s.room.size, Eigen::Vector3d(5, 4, 2.5));
  ASSERT_EQ(s.solids.size(), 2u);
  EXPECT_TRUE(s.solids[0].supports_object);
  EXPECT_EQ(s.solids[1].shape, Shape::cylinder);
  EXPECT_EQ(s.solids[1].size, Eigen::Vector3d(0.3, 0.3, 2));
  EXPECT_NEAR((s.solids[1].X_WS.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 0, 1e-12);
  EXPECT_EQ(s.landmarks.at(0).normal, Eigen::Vector3d(-1, 0, 0));
  EXPECT_NEAR(s.robot_start.yaw, std::numbers::pi / 2, 1e-12);
  ASSERT_TRUE(s.truth.has_value());
  EXPECT_EQ(s.truth->up_axis, "y");
  EXPECT_DOUBLE_EQ(s.truth->X_WO.translation().z(), 0.7);
}

TEST(Scene, RefusesWhatCannotBeUsed) {
  EXPECT_NE(message_of(replaced(kText, "pillar", "table")).find("already taken"), std::string::npos);
  EXPECT_NE(message_of(replaced(kText, "0.7, 0.7, 0.7", "0.7, -0.7, 0.7")).find("size"), std::string::npos);
  EXPECT_NE(message_of(replaced(kText, "cylinder", "cone")).find("shape"), std::string::npos);
  EXPECT_NE(message_of(replaced(kText, "x_m: -1.5", "x_m: -9")).find("outside the room"), std::string::npos);
  EXPECT_NE(message_of(replaced(kText, "noise:3", "noise:x")).find("seed"), std::string::npos);
  EXPECT_NE(message_of(replaced(kText, "floor.png", "../../etc/passwd")).find("assets"), std::string::npos);
  EXPECT_NE(message_of(replaced(kText, "floor.png", "/etc/passwd.png")).find("assets"), std::string::npos);
  EXPECT_NE(message_of(replaced(kText, "diameter_m", "diametre_m")), "");
  EXPECT_NE(message_of(replaced(kText, "[0, 0, 0.35]", "[0, .nan, 0.35]")), "");
  EXPECT_NE(message_of("name: ["), "");
  EXPECT_THROW(load_scene("/nowhere/scene.yaml"), Error);
}

TEST(Scene, MeshesOfTooManyTrianglesTogetherAreRefused) {
  const auto ships = [](int count) {
    std::string text = "name: harbour\nsolids:\n";
    for (int n = 0; n < count; ++n)
      text += "  - {name: s" + std::to_string(n) + ", shape: mesh, mesh: \"made:ship\", longest_side_m: 1, position_m: [0, 0, 1]}\n";
    return parse_scene(text, "harbour.yaml");
  };
  EXPECT_EQ(ships(2).solids.size(), 2u);
  try {
    ships(256);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    EXPECT_NE(std::string(e.what()).find("together"), std::string::npos) << e.what();
  }
}

TEST(Scene, SolidsMayBeMeshesOfTheAssetsFolder) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / ("scene_test." + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const char* before = std::getenv("PERIPLUS_ASSETS");
  const std::string kept = before ? before : "";
  ::setenv("PERIPLUS_ASSETS", folder.c_str(), 1);
  mesh::write_ply(mesh::make_box({2, 4, 1}, 1), folder / "block.ply");  // its y goes up
  const auto text = [](const std::string& solid) { return "name: yard\nsolids:\n  - {name: block, shape: mesh, " + solid + "}\n"; };
  const Scene s = parse_scene(text("mesh: block.ply, longest_side_m: 0.8, up_axis: y, position_m: [1, 0, 0.4], yaw_deg: 90"), "s.yaml");
  ASSERT_EQ(s.solids.size(), 1u);
  const Solid& block = s.solids[0];
  EXPECT_EQ(block.shape, Shape::mesh);
  ASSERT_NE(block.mesh, nullptr);
  EXPECT_TRUE(block.mesh->closed());
  EXPECT_NEAR(block.size.z(), 0.8, 1e-6);
  EXPECT_NEAR(block.size.x() * block.size.y(), 0.2 * 0.4, 1e-6);
  EXPECT_NEAR(mesh::signed_volume(block.mesh->mesh()), 0.2 * 0.4 * 0.8, 1e-6);
  // It stands on the floor, as a box of that size and place would.
  const CollisionWorld world(s);
  EXPECT_NEAR(world.first_hit({1, 0, 3}, {1, 0, 0}).value_or(-1), (3 - 0.8) / 3, 1e-6);
  EXPECT_TRUE(world.contains({1, 0, 0.01}));
  EXPECT_NE(message_of(text("mesh: nowhere.ply, longest_side_m: 1, position_m: [0, 0, 0]")).find("nowhere.ply"), std::string::npos);
  EXPECT_NE(message_of(text("mesh: nowhere.ply, longest_side_m: 1, position_m: [0, 0, 0]")).find("s.yaml:3"), std::string::npos);
  EXPECT_NE(message_of(text("mesh: ../block.ply, longest_side_m: 1, position_m: [0, 0, 0]")).find("assets"), std::string::npos);
  EXPECT_NE(message_of(text("mesh: /etc/passwd, longest_side_m: 1, position_m: [0, 0, 0]")).find("assets"), std::string::npos);
  EXPECT_NE(message_of(text("mesh: block.ply, position_m: [0, 0, 0]")).find("longest_side_m"), std::string::npos);
  EXPECT_NE(message_of(text("longest_side_m: 1, position_m: [0, 0, 0]")).find("mesh"), std::string::npos);
  if (before) ::setenv("PERIPLUS_ASSETS", kept.c_str(), 1);
  else ::unsetenv("PERIPLUS_ASSETS");
  std::filesystem::remove_all(folder);
}

TEST(Scene, TruthIsTakenOut) {
  const std::string kept = without_truth(kText);
  EXPECT_EQ(kept.find("bunny"), std::string::npos);
  EXPECT_EQ(kept.find("0.45"), std::string::npos);
  const Scene s = parse_scene(kept, "s.yaml");
  EXPECT_FALSE(s.truth.has_value());
  EXPECT_EQ(s.solids.size(), 2u);
  // In the middle of a file, and quoted.
  const std::string middle = "name: a\n\"truth\" :\n  mesh: m.obj\n\n  position_m: [0, 0, 0]\nrobot_start: {x_m: 1}\n";
  const std::string rest = without_truth(middle);
  EXPECT_EQ(rest.find("m.obj"), std::string::npos);
  EXPECT_DOUBLE_EQ(parse_scene(rest, "s").robot_start.x, 1);
  EXPECT_THROW(without_truth("{name: a, truth: {mesh: m.obj}}"), Error);
}

}  // namespace
}  // namespace periplus::scene
