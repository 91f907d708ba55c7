#include "common/scene/mesh_solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/mesh/part_builder.h"
#include "common/scene/scene.h"

namespace periplus::scene {
namespace {

using Eigen::Vector3d;

Vector3d around_origin(Random& random, double reach) { return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)}; }

// A ring of radius 0.5 about z, 0.1 thick.
mesh::TriangleMesh ring() {
  std::vector<Vector3d> line;
  for (int k = 0; k < 64; ++k) line.emplace_back(0.5 * std::cos(2 * std::numbers::pi * k / 64), 0.5 * std::sin(2 * std::numbers::pi * k / 64), 0);
  mesh::PartBuilder b(1);
  b.tube(line, std::vector<double>(64, 0.1), 24, mesh::Material::stone, true);
  return b.mesh();
}

// Two triangles at x = 0, a metre wide and high.
mesh::TriangleMesh sheet() {
  mesh::TriangleMesh m;
  m.vertices = {{0, -0.5, -0.5}, {0, 0.5, -0.5}, {0, 0.5, 0.5}, {0, -0.5, 0.5}};
  m.triangles = {{0, 1, 2}, {0, 2, 3}};
  return m;
}

Solid solid_of(mesh::TriangleMesh m, const Pose& X_WS) {
  Solid s;
  s.name = "mesh";
  s.shape = Shape::mesh;
  s.mesh = std::make_shared<const MeshSolid>(std::move(m));
  s.size = s.mesh->size();
  s.X_WS = X_WS;
  return s;
}

// A box as a mesh is a box: in all that a collision world answers.
TEST(MeshSolid, ABoxOfTrianglesIsABox) {
  const Vector3d size(0.6, 0.4, 1.0);
  Solid box;
  box.name = "box";
  box.size = size;
  box.X_WS = make_pose({0.2, -0.1, 0.9}, rotation_from_yaw_pitch_roll(0.5, 0.2, -0.3));
  Scene boxes, meshes;
  boxes.room.size = meshes.room.size = {6, 6, 3};
  boxes.solids = {box};
  meshes.solids = {solid_of(mesh::make_box(size, 1), box.X_WS)};
  EXPECT_TRUE(meshes.solids[0].mesh->closed());
  EXPECT_TRUE(meshes.solids[0].size.isApprox(size));
  const CollisionWorld a(boxes), b(meshes);
  Random random(8);
  int inside = 0, hits = 0, touching = 0, deep = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Vector3d p = box.X_WS * around_origin(random, 0.8), q = box.X_WS * around_origin(random, 0.8);
    const Closest at_box = a.capsule_distance_to(0, p, p, 0), at_mesh = b.capsule_distance_to(0, p, p, 0);
    EXPECT_NEAR(at_mesh.distance, at_box.distance, 1e-9);
    if (at_box.distance > 1e-3) {
      EXPECT_LT((at_mesh.on_solid - at_box.on_solid).norm(), 1e-9);
    }
    inside += at_mesh.distance < 0;
    EXPECT_EQ(b.contains(p), a.contains(p));
    EXPECT_EQ(b.contains(p, 0.1), a.contains(p, 0.1));
    const auto hit_box = a.first_hit(p, q), hit_mesh = b.first_hit(p, q);
    ASSERT_EQ(hit_mesh.has_value(), hit_box.has_value()) << trial;
    if (hit_box) {
      EXPECT_NEAR(*hit_mesh, *hit_box, 1e-9);
    }
    hits += hit_box.has_value();
    const double capsule_box = a.capsule_distance_to(0, p, q, 0.05).distance, capsule_mesh = b.capsule_distance_to(0, p, q, 0.05).distance;
    if (capsule_box > -0.05) {
      EXPECT_NEAR(capsule_mesh, capsule_box, 1e-6);
    } else {  // a bound of the depth
      EXPECT_LT(capsule_mesh, -0.05 + 1e-9);
      EXPECT_GE(capsule_mesh, capsule_box - 1e-6);
      ++deep;
    }
    if (trial % 5 == 0) {
      const Pose X_WB = make_pose(p, rotation_from_yaw_pitch_roll(random.uniform(-3, 3), random.uniform(-1, 1), random.uniform(-1, 1)));
      const Vector3d sides(random.uniform(0.02, 0.5), random.uniform(0.02, 0.5), random.uniform(0.02, 0.5));
      if (a.box_touches_solid(X_WB, sides * 0.999) != a.box_touches_solid(X_WB, sides * 1.001)) continue;  // hardly
      EXPECT_EQ(b.box_touches_solid(X_WB, sides), a.box_touches_solid(X_WB, sides)) << trial;
      touching += b.box_touches_solid(X_WB, sides);
    }
  }
  EXPECT_GT(inside, 50);
  EXPECT_GT(hits, 200);
  EXPECT_GT(deep, 100);
  EXPECT_GT(touching, 50);
}

// What no convex shape can be: free in the middle.
TEST(MeshSolid, OneReachesThroughARing) {
  Scene s;
  s.room.size = {6, 6, 3};
  s.solids = {solid_of(ring(), make_pose({0, 0, 1}, Eigen::Matrix3d::Identity()))};
  const CollisionWorld w(s);
  EXPECT_FALSE(w.contains({0, 0, 1}));
  EXPECT_TRUE(w.contains({0.5, 0, 1}));
  EXPECT_FALSE(w.first_hit({0, 0, 2}, {0, 0, 0.1}).has_value());
  EXPECT_NEAR(w.first_hit({0, 0, 1}, {1, 0, 1}).value_or(-1), 0.4, 1e-3);  // from the middle outwards
  EXPECT_NEAR(w.first_hit({0.5, 0, 2}, {0.5, 0, 1}).value_or(-1), 0.9, 2e-3);
  EXPECT_EQ(w.first_hit({0.5, 0, 1}, {2, 0, 1}), 0);
  const Closest c = w.capsule_distance({0, 0, 1.5}, {0, 0, 0.5}, 0.05, 10);
  EXPECT_NEAR(c.distance, 0.35, 2e-3);
  EXPECT_NEAR(c.on_solid.z(), 1, 0.02);
  EXPECT_LT(w.capsule_distance({0, 0, 1}, {1, 0, 1}, 0.05, 10).distance, -0.1) << "across the ring";
  EXPECT_FALSE(w.box_touches_solid(make_pose({0, 0, 1}, Eigen::Matrix3d::Identity()), {0.5, 0.5, 3}));
  EXPECT_TRUE(w.box_touches_solid(make_pose({0, 0, 1}, Eigen::Matrix3d::Identity()), {0.6, 0.6, 3}));
  EXPECT_TRUE(w.box_touches_solid(make_pose({0.5, 0, 1}, Eigen::Matrix3d::Identity()), {0.02, 0.02, 0.02})) << "as a whole inside";
}

TEST(MeshSolid, ASheetIsASkinWithoutAnInside) {
  Scene s;
  s.room.size = {6, 6, 3};
  s.solids = {solid_of(sheet(), make_pose({1, 0, 1}, Eigen::Matrix3d::Identity()))};
  EXPECT_FALSE(s.solids[0].mesh->closed());
  const CollisionWorld w(s);
  for (double side : {-1.0, 1.0}) {
    const Vector3d p(1 + 0.4 * side, 0.1, 1.2);
    EXPECT_FALSE(w.contains(p));
    EXPECT_NEAR(w.capsule_distance_to(0, p, p, 0.1).distance, 0.3, 1e-12);
    EXPECT_NEAR(w.capsule_distance_to(0, p, p, 0.1).on_shape.x(), 1 + 0.3 * side, 1e-12);
    EXPECT_NEAR(w.first_hit(p, {1 - 0.4 * side, 0.1, 1.2}).value_or(-1), 0.5, 1e-12);
  }
  EXPECT_TRUE(w.contains({1.01, 0, 1}, 0.02));
  EXPECT_TRUE(w.box_touches_solid(make_pose({1.04, 0, 1}, Eigen::Matrix3d::Identity()), {0.1, 0.1, 0.1}));
  EXPECT_FALSE(w.box_touches_solid(make_pose({1.06, 0, 1}, Eigen::Matrix3d::Identity()), {0.1, 0.1, 0.1}));
}

TEST(MeshSolid, StandsAboutItsMiddleAndFacesOutwards) {
  mesh::TriangleMesh m = mesh::make_box({0.2, 0.4, 0.6}, 1);
  mesh::flip(m);
  for (Vector3d& p : m.vertices) p += Vector3d(3, 4, 5);
  const MeshSolid s(m);
  EXPECT_GT(mesh::signed_volume(s.mesh()), 0);
  EXPECT_TRUE(s.size().isApprox(Vector3d(0.2, 0.4, 0.6)));
  Vector3d outwards;
  EXPECT_NEAR(s.distance({0, 0, 0}, outwards), -0.1, 1e-12);
  EXPECT_NEAR(s.distance({0.1, 0, 0}, outwards), 0, 1e-12);
  EXPECT_GT(outwards.x(), 0.99);
}

TEST(MeshSolid, MadeOnesAreLoadedUprightAndScaled) {
  EXPECT_THROW(MeshSolid::load("made:nothing", 1, "z"), Error);
  EXPECT_THROW(MeshSolid::load("no such file.obj", 1, "z"), Error);
  EXPECT_THROW(MeshSolid(mesh::TriangleMesh{}), Error);
  mesh::TriangleMesh many;
  many.vertices = sheet().vertices;
  many.triangles.assign(MeshSolid::kMostTriangles + 1, {0, 1, 2});
  EXPECT_THROW(MeshSolid{many}, Error);
}

}  // namespace
}  // namespace periplus::scene
