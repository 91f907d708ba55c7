#include "common/render/renderer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/mesh/part_builder.h"
#include "common/mesh/triangle_tree.h"
#include "common/scene/mesh_solid.h"

namespace periplus::render {
namespace {

using Eigen::Vector3d;

scene::Scene small_room() {
  scene::Scene room = scene::parse_scene(R"(
name: test
room: {size_m: [4, 4, 2.5], wall_texture: "noise:1", floor_texture: "noise:2"}
solids:
  - {name: table, size_m: [0.7, 0.7, 0.7], position_m: [0, 0, 0.35], texture: "noise:3"}
  - {name: pillar, shape: cylinder, diameter_m: 0.3, height_m: 2, position_m: [0.5, 1.0, 1], rgb: [0.9, 0.2, 0.1]}
  - {name: ball, shape: sphere, diameter_m: 0.4, position_m: [0.9, -0.8, 0.2], texture: "noise:4"}
lights: [{position_m: [-1, -1, 2.4], intensity: 0.5}]
landmarks: [{name: mark, position_m: [2, 0.3, 1.4], normal: [-1, 0, 0], size_m: 0.3}]
)",
                            "test");
  mesh::PartBuilder stone(1);
  stone.lump({0, 0, 0}, {0.1, 0.15, 0.08}, 0.3, 5, mesh::Material::stone);
  scene::Solid boulder;
  boulder.name = "boulder";
  boulder.shape = scene::Shape::mesh;
  boulder.mesh = std::make_shared<const scene::MeshSolid>(stone.mesh());
  boulder.size = boulder.mesh->size();
  boulder.X_WS = make_pose({0.1, -0.45, 0.85}, rotation_from_yaw_pitch_roll(0.4, 0.3, 0));
  boulder.texture = "noise:6";
  room.solids.push_back(boulder);
  return room;
}

// A bumpy ball on the table: concave enough to hide parts of itself.
TrueObject bumpy_object() {
  TrueObject object;
  object.texture = "noise:5";
  object.mesh_W = mesh::make_sphere(0.3, 1);
  for (Vector3d& p : object.mesh_W.vertices) p *= 1 + 0.2 * std::sin(20 * p.x()) * std::cos(17 * p.y() + 1);
  mesh::transform(object.mesh_W, make_pose({0.05, -0.02, 0.9}, Eigen::Matrix3d::Identity()));
  mesh::compute_normals(object.mesh_W);
  mesh::unwrap_six_tiles(object.mesh_W, 0.5);
  return object;
}

Pinhole eye() { return Pinhole::from_vertical_fov(320, 240, 25 * std::numbers::pi / 180); }

RendererOptions small_pictures() {
  RendererOptions options;
  options.max_width = 320;
  options.max_height = 240;
  return options;
}

class RendererTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { renderer_ = new Renderer(small_room(), {bumpy_object()}, small_pictures()); }
  static void TearDownTestSuite() {
    delete renderer_;
    renderer_ = nullptr;
  }
  static Renderer* renderer_;
};
Renderer* RendererTest::renderer_ = nullptr;

// Every fourth pixel's depth against rays through object, solids and room, computed without the renderer.
TEST_F(RendererTest, DepthIsThatOfRays) {
  const TrueObject object = bumpy_object();
  const mesh::TriangleTree tree(object.mesh_W);
  const scene::CollisionWorld world(small_room());
  scene::Scene only = small_room();
  only.solids.erase(only.solids.begin(), only.solids.end() - 1);
  const scene::CollisionWorld boulder(only);
  int on_boulder = 0;
  const Pinhole camera = eye();
  for (const Vector3d& from : {Vector3d(-1.2, 0, 1.2), Vector3d(0.3, -1.3, 1.35), Vector3d(1.2, 0.8, 1.0)}) {
    const Pose X = look_at(from, {0, 0, 0.85});
    const RenderedView view = renderer_->render(X, camera);
    int compared = 0, off = 0, on_object = 0;
    double sum = 0;
    for (int v = 2; v < camera.height; v += 4)
      for (int u = 2; u < camera.width; u += 4) {
        const Vector3d direction = X.linear() * camera.back_project(u, v, 1.0);
        double z = 1e9;
        for (int axis = 0; axis < 2; ++axis) {
          const double wall = (direction[axis] > 0 ? 2.0 : -2.0);
          if (std::abs(direction[axis]) > 1e-12) z = std::min(z, (wall - from[axis]) / direction[axis]);
        }
        if (direction.z() < 0) z = std::min(z, -from.z() / direction.z());
        if (from.z() + z * direction.z() > 2.5) continue;  // above the walls
        if (const auto t = world.first_hit(from, from + 10 * direction)) z = std::min(z, *t * 10);
        on_boulder += boulder.first_hit(from, from + z * (1 + 1e-9) * direction).has_value();
        if (const auto hit = tree.ray(from, direction, z)) {
          z = hit->t;
          ++on_object;
        }
        ++compared;
        const double error = std::abs(view.depth.at(u, v) - z);
        if (error > 0.003) ++off;  // at outlines
        else sum += error;
      }
    EXPECT_GT(on_object, 200);
    EXPECT_LT(off, 0.01 * compared);
    EXPECT_LT(sum / (compared - off), 1e-4);
  }
  EXPECT_GT(on_boulder, 100);
}

// A surface point has the same colour in both eyes, at the column that its depth says.
TEST_F(RendererTest, EyesAgreeAtTheDisparityOfTheDepth) {
  const StereoRig rig{eye(), 0.144};
  const Pose X_left = look_at({-1.2, 0.1, 1.2}, {0, 0, 0.85});
  const Pose X_right = X_left * make_pose({rig.baseline, 0, 0}, Eigen::Matrix3d::Identity());
  const RenderedView left = renderer_->render(X_left, rig.camera), right = renderer_->render(X_right, rig.camera);
  std::vector<double> differences, shifted;
  for (int v = 4; v < 236; ++v)
    for (int u = 4; u < 316; ++u) {
      const double z = left.depth.at(u, v);
      if (z <= 0) continue;
      const double column = u - rig.disparity(z);
      if (column < 4 || column > 314) continue;
      const int c0 = static_cast<int>(column);
      if (std::abs(right.depth.at(c0, v) - z) > 0.01 || std::abs(right.depth.at(c0 + 1, v) - z) > 0.01) continue;  // hidden from the right eye
      const double share = column - c0;
      const double found = (1 - share) * right.colour.at(c0, v, 1) + share * right.colour.at(c0 + 1, v, 1);
      differences.push_back(std::abs(found - left.colour.at(u, v, 1)));
      shifted.push_back(std::abs(right.colour.at(c0 - 3, v, 1) - static_cast<double>(left.colour.at(u, v, 1))));
    }
  ASSERT_GT(differences.size(), 10000u);
  const auto median = [](std::vector<double>& d) {
    std::nth_element(d.begin(), d.begin() + static_cast<std::ptrdiff_t>(d.size() / 2), d.end());
    return d[d.size() / 2];
  };
  const double agreed = median(differences), apart = median(shifted);
  EXPECT_LT(agreed, 4);           // grey levels; resampling of fine texture
  EXPECT_GT(apart, 2 * agreed);   // three pixels beside it does not fit
}

TEST_F(RendererTest, SameBytesAgainAndFromAnotherRenderer) {
  const Pose X = look_at({-1.2, 0, 1.2}, {0, 0, 0.85});
  const RenderedView first = renderer_->render(X, eye());
  EXPECT_EQ(renderer_->render(X, eye()).colour.data, first.colour.data);
  Renderer other(small_room(), {bumpy_object()}, small_pictures());
  EXPECT_EQ(other.render(X, eye()).colour.data, first.colour.data);
  EXPECT_EQ(other.render(X, eye()).depth.data, first.depth.data);
  // The first one's context is still its own.
  EXPECT_EQ(renderer_->render(X, eye()).colour.data, first.colour.data);
}

TEST_F(RendererTest, CameraOffCentre) {
  const Pose X = look_at({-1.2, 0, 1.2}, {0, 0, 0.85});
  Pinhole shifted = eye();
  shifted.cx += 20;
  shifted.cy -= 10;
  const RenderedView centred = renderer_->render(X, eye()), moved = renderer_->render(X, shifted);
  int same = 0, all = 0;
  for (int v = 20; v < 200; ++v)
    for (int u = 20; u < 280; ++u, ++all) same += std::abs(moved.depth.at(u + 20, v - 10) - centred.depth.at(u, v)) < 1e-3f;
  EXPECT_GT(same, 0.99 * all);
}

TEST_F(RendererTest, BadRequestsAreRefused) {
  const Pose X = look_at({-1.2, 0, 1.2}, {0, 0, 0.85});
  Pinhole camera = eye();
  camera.fy *= 1.1;
  EXPECT_THROW(renderer_->render(X, camera), Error);
  EXPECT_THROW(renderer_->render(X, Pinhole::from_vertical_fov(640, 480, 0.4)), Error);
  Pose bad = X;
  bad.translation().x() = std::nan("");
  EXPECT_THROW(renderer_->render(bad, eye()), Error);
  scene::Scene s = small_room();
  s.solids[0].texture = "no-such-picture.png";
  EXPECT_THROW(Renderer(s, {}), Error);
}

}  // namespace
}  // namespace periplus::render
