#include "integration-tests/evaluation/obstacles.h"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>

#include "common/core/random.h"
#include "common/mesh/triangle_mesh.h"
#include "common/scene/mesh_solid.h"

namespace periplus::evaluation {
namespace {

using Eigen::Vector3d;

scene::Scene scene_of(const scene::Solid& solid) {
  scene::Scene scene;
  scene.solids = {solid};
  return scene;
}

scene::Solid solid_of(scene::Shape shape, const Vector3d& size, const Pose& X_WS) {
  scene::Solid solid;
  solid.shape = shape;
  solid.size = size;
  solid.X_WS = X_WS;
  return solid;
}

Pose turned(const Vector3d& p, double yaw, double pitch = 0, double roll = 0) { return make_pose(p, rotation_from_yaw_pitch_roll(yaw, pitch, roll)); }

TEST(Obstacles, SegmentsMeetWhatTheyPassThrough) {
  const Obstacles box(scene_of(solid_of(scene::Shape::box, {1, 1, 1}, turned({0, 0, 1}, std::numbers::pi / 4))));
  EXPECT_TRUE(box.block({-2, 0, 1}, {2, 0, 1}));
  EXPECT_TRUE(box.block({0, 0, 1}, {0, 0.1, 1}));          // within
  EXPECT_TRUE(box.block({0.65, -1, 1}, {0.65, 1, 1}));     // the turned corner reaches 0.707
  EXPECT_FALSE(box.block({0.75, -1, 1}, {0.75, 1, 1}));
  EXPECT_FALSE(box.block({-2, 0, 1}, {-0.8, 0, 1}));       // ends before
  EXPECT_FALSE(box.block({-2, 0, 1.6}, {2, 0, 1.6}));
  const Obstacles cylinder(scene_of(solid_of(scene::Shape::cylinder, {1, 1, 2}, turned({0, 0, 1}, 0))));
  EXPECT_TRUE(cylinder.block({-2, 0.49, 1}, {2, 0.49, 1}));
  EXPECT_FALSE(cylinder.block({-2, 0.51, 1}, {2, 0.51, 1}));
  EXPECT_TRUE(cylinder.block({0, 0, 3}, {0, 0, 1.9}));     // along the axis
  EXPECT_FALSE(cylinder.block({0, 0, 3}, {0, 0, 2.1}));
  EXPECT_FALSE(cylinder.block({-2, 0, 2.6}, {2, 0, 2.1}));
  const Obstacles sphere(scene_of(solid_of(scene::Shape::sphere, {1, 1, 1}, turned({0, 0, 1}, 0))));
  EXPECT_TRUE(sphere.block({-2, 0, 1.49}, {2, 0, 1.49}));
  EXPECT_FALSE(sphere.block({-2, 0, 1.51}, {2, 0, 1.51}));
}

TEST(Obstacles, BoxesTouchSolidsAndWalls) {
  const Vector3d body(0.5, 0.6, 1.5);
  const Obstacles box(scene_of(solid_of(scene::Shape::box, {1, 1, 2}, turned({0, 0, 1}, 0))));
  EXPECT_TRUE(box.touch_box(turned({0.7, 0, 0.8}, 0), body));
  EXPECT_FALSE(box.touch_box(turned({0.76, 0, 0.8}, 0), body));
  EXPECT_TRUE(box.touch_box(turned({0.76, 0, 0.8}, 0.5), body));        // its corner
  EXPECT_TRUE(box.touch_box(turned({0, 0, 0.8}, 0.5), {0.1, 0.1, 0.1}));  // within
  EXPECT_FALSE(box.touch_box(turned({0, 0, 2.8}, 0.5), body));          // above
  EXPECT_TRUE(box.touch_box(turned({2.8, 0, 0.8}, 0), body));           // the wall at 3 m
  EXPECT_FALSE(box.touch_box(turned({2.7, 0, 0.8}, 0), body));
  const Obstacles pillar(scene_of(solid_of(scene::Shape::cylinder, {0.4, 0.4, 2}, turned({0, 0, 1}, 0))));
  EXPECT_TRUE(pillar.touch_box(turned({0.44, 0, 0.8}, 0), body));
  EXPECT_FALSE(pillar.touch_box(turned({0.46, 0, 0.8}, 0), body));
  EXPECT_FALSE(pillar.touch_box(turned({0.40, 0.45, 0.8}, 0), body));   // past the corner that a square pillar would have
  const Obstacles ball(scene_of(solid_of(scene::Shape::sphere, {0.4, 0.4, 0.4}, turned({0, 0, 0.2}, 0))));
  EXPECT_TRUE(ball.touch_box(turned({0, 0, 1.14}, 0), body));
  EXPECT_FALSE(ball.touch_box(turned({0, 0, 1.16}, 0), body));
}

// Against points strewn in the box: one that lies in the solid is a contact, and a contact has a point near the solid.
TEST(Obstacles, ABoxOfTrianglesIsABox) {
  const Pose X_WS = turned({0.1, -0.2, 1}, 0.6, 0.3);
  const Vector3d size(0.8, 0.5, 0.6);
  scene::Solid mesh = solid_of(scene::Shape::mesh, size, X_WS);
  mesh.mesh = std::make_shared<const scene::MeshSolid>(mesh::make_box(size, 1));
  const Obstacles box(scene_of(solid_of(scene::Shape::box, size, X_WS))), triangles(scene_of(mesh));
  Random random(9);
  const auto point = [&] { return Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0, 2)); };
  int touching = 0, blocked = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Vector3d p = point(), q = point(), sides(random.uniform(0.02, 0.6), random.uniform(0.02, 0.6), random.uniform(0.02, 0.6));
    EXPECT_EQ(triangles.block(p, q), box.block(p, q)) << trial;
    blocked += box.block(p, q);
    const double ball = random.uniform(0.05, 0.4);
    EXPECT_EQ(triangles.touch_ball(p, ball), box.touch_ball(p, ball)) << trial;
    const Pose X_WB = turned(q, random.uniform(-3, 3), random.uniform(-1, 1), random.uniform(-1, 1));
    if (box.touch_box(X_WB, 0.99 * sides) != box.touch_box(X_WB, 1.01 * sides)) continue;  // hardly
    EXPECT_EQ(triangles.touch_box(X_WB, sides), box.touch_box(X_WB, sides)) << trial;
    touching += box.touch_box(X_WB, sides);
  }
  EXPECT_GT(touching, 50);
  EXPECT_GT(blocked, 50);
}

TEST(Obstacles, BoxesAgreeWithPointsStrewnInThem) {
  Random random(4);
  int touching = 0, free = 0;
  for (int round = 0; round < 300; ++round) {
    const auto angle = [&] { return random.uniform(-3, 3); };
    const auto place = [&] { return Vector3d(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8), random.uniform(0.5, 1.5)); };
    const auto shape = static_cast<scene::Shape>(random.below(3));
    const double across = random.uniform(0.2, 0.8);
    const Vector3d size = shape == scene::Shape::box ? Vector3d(across, random.uniform(0.2, 0.8), random.uniform(0.2, 0.8)) : Vector3d(across, across, random.uniform(0.2, 0.8));
    const Obstacles obstacles(scene_of(solid_of(shape, size, turned(place(), angle(), angle(), angle()))));
    const Pose X_WB = turned(place(), angle(), angle(), angle());
    const Vector3d body(random.uniform(0.2, 0.8), random.uniform(0.2, 0.8), random.uniform(0.2, 0.8));
    bool within = false, near = false;
    for (int i = 0; i < 4000 && !within; ++i) {
      const Vector3d p = X_WB * Vector3d(random.uniform(-0.5, 0.5) * body.x(), random.uniform(-0.5, 0.5) * body.y(), random.uniform(-0.5, 0.5) * body.z());
      within = obstacles.touch_ball(p, 0);
      near = near || obstacles.touch_ball(p, 0.08);
    }
    const bool touch = obstacles.touch_box(X_WB, body);
    EXPECT_TRUE(touch || !within) << round;
    EXPECT_TRUE(within || near || !touch) << round;
    ++(touch ? touching : free);
  }
  EXPECT_GT(touching, 50);
  EXPECT_GT(free, 50);
}

}  // namespace
}  // namespace periplus::evaluation
