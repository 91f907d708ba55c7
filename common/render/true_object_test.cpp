#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "common/core/error.h"
#include "common/render/renderer.h"

namespace periplus::render {
namespace {

TEST(TrueObject, StandsWhereTheSceneSays) {
  const auto folder = std::filesystem::temp_directory_path() / ("true_object_test-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  mesh::TriangleMesh box = mesh::make_box({10, 20, 40}, 1);
  mesh::flip(box);  // inside out, as some files are
  mesh::write_ply(box, folder / "box.ply");
  scene::Truth truth;
  truth.mesh = "box.ply";
  truth.longest_side = 0.4;
  truth.up_axis = "y";
  truth.X_WO = make_pose({0.1, 0.2, 0.7}, rotation_from_yaw_pitch_roll(1.5707963267948966, 0, 0));
  const TrueObject object = load_true_object(truth, {folder.string()});
  const mesh::Bounds b = mesh::bounds(object.mesh_W);
  // y up: x stays 0.1 wide, z becomes the depth of 0.4; turned by 90 degrees.
  EXPECT_NEAR((b.size() - Eigen::Vector3d(0.4, 0.1, 0.2)).norm(), 0, 1e-6);
  EXPECT_NEAR((b.lower - Eigen::Vector3d(-0.1, 0.15, 0.7)).norm(), 0, 1e-6);
  EXPECT_NEAR(object.scale, 0.01, 1e-9);
  EXPECT_GT(mesh::signed_volume(object.mesh_W), 0);
  EXPECT_EQ(object.mesh_W.corner_uv.size(), 3 * object.mesh_W.triangles.size());
  // The published pose takes the file's points to the world.
  const mesh::TriangleMesh raw = mesh::load(folder / "box.ply");
  EXPECT_NEAR((object.X_WM * (object.scale * raw.vertices[3]) - object.mesh_W.vertices[3]).norm(), 0, 1e-9);
  truth.mesh = "absent.ply";
  EXPECT_THROW(load_true_object(truth, {folder.string()}), Error);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace periplus::render
