#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/random.h"
#include "common/scene/scene.h"

namespace periplus::scene {
namespace {

using Eigen::Vector3d;

Solid solid(const char* name, Shape shape, const Vector3d& size, const Pose& X_WS) {
  Solid s;
  s.name = name;
  s.shape = shape;
  s.size = size;
  s.X_WS = X_WS;
  return s;
}

Scene three_shapes() {
  Scene s;
  s.room.size = {6, 6, 3};
  s.solids = {
      solid("box", Shape::box, {0.6, 0.4, 1.0}, make_pose({1, 0, 0.5}, rotation_from_yaw_pitch_roll(0.5, 0.2, 0))),
      solid("cylinder", Shape::cylinder, {0.4, 0.4, 1.2}, make_pose({-1, 0.5, 0.6}, rotation_from_yaw_pitch_roll(0, 0, 0.4))),
      solid("sphere", Shape::sphere, {0.5, 0.5, 0.5}, make_pose({0, -1, 1}, Eigen::Matrix3d::Identity()))};
  return s;
}

Vector3d random_point(Random& random, double reach) {
  return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(0, reach)};
}

TEST(CollisionWorld, KnownDistances) {
  Scene s;
  s.room.size = {6, 6, 3};
  s.solids = {solid("box", Shape::box, {1, 1, 1}, make_pose({0, 0, 0.5}, Eigen::Matrix3d::Identity()))};
  const CollisionWorld w(s);
  // Beside a face, along an edge, in depth.
  Closest c = w.capsule_distance({1, -0.2, 0.5}, {1, 0.2, 0.5}, 0.1, 10);
  EXPECT_NEAR(c.distance, 0.4, 1e-9);
  EXPECT_EQ(c.solid, 0);
  EXPECT_NEAR(c.on_solid.x(), 0.5, 1e-9);
  EXPECT_NEAR(c.on_shape.x(), 0.9, 1e-9);
  EXPECT_NEAR(w.capsule_distance({0, -1, 1.5}, {0, 1, 1.5}, 0.1, 10).distance, 0.4, 1e-9);
  EXPECT_NEAR(w.capsule_distance({0.4, 0, 0.5}, {2, 0, 0.5}, 0.1, 10).distance, -0.2, 1e-9);
  EXPECT_NEAR(w.capsule_distance({1, 1, 0.5}, {2, 2, 0.5}, 0.1, 10).distance, std::sqrt(0.5) - 0.1, 1e-9);
  // Walls, range, floor left out.
  c = w.capsule_distance({2.5, 0, 0.1}, {2.8, 0, 0.1}, 0.05, 10);
  EXPECT_EQ(c.solid, -2);
  EXPECT_NEAR(c.distance, 0.15, 1e-9);
  EXPECT_DOUBLE_EQ(w.capsule_distance({1.7, 1.7, 1}, {1.7, 1.7, 1}, 0.1, 0.05).distance, 0.05);
  EXPECT_NEAR(w.capsule_distance_to(-1, {1, 1, 0.5}, {1, 1, 0.2}, 0.1).distance, 0.1, 1e-9);
  EXPECT_THROW(w.capsule_distance_to(1, {1, 1, 0.5}, {1, 1, 0.2}, 0.1), std::exception);
}

// The segment's least distance against dense sampling of it: no shape may be nearer or farther than said.
TEST(CollisionWorld, CapsuleAgreesWithSampling) {
  const CollisionWorld w(three_shapes());
  Random random(7);
  for (int trial = 0; trial < 300; ++trial) {
    const Vector3d a = random_point(random, 1.6), b = a + 0.5 * Vector3d(random.normal(), random.normal(), random.normal());
    for (int solid = 0; solid < 3; ++solid) {
      const Closest c = w.capsule_distance_to(solid, a, b, 0.07);
      double least = 1e9;
      for (int i = 0; i <= 400; ++i) {
        const Vector3d p = a + (b - a) * (i / 400.0);
        least = std::min(least, w.capsule_distance_to(solid, p, p, 0.07).distance);
      }
      EXPECT_LE(c.distance, least + 1e-9);
      EXPECT_GE(c.distance, least - (b - a).norm() / 400);
      if (c.distance > 0) {
        EXPECT_NEAR((c.on_shape - c.on_solid).norm(), c.distance, 1e-6);
      }
    }
  }
}

// Against the closed form of each shape.
TEST(CollisionWorld, FirstHitIsWhereTheSegmentEnters) {
  const auto hit = [](Shape shape, const Vector3d& size, const Vector3d& p, const Vector3d& q, const Pose& X_WS = make_pose({0, 0, 1}, Eigen::Matrix3d::Identity())) {
    Scene s;
    s.room.size = {6, 6, 3};
    s.solids = {solid("one", shape, size, X_WS)};
    return CollisionWorld(s).first_hit(p, q).value_or(-1);
  };
  // A box of 0.4 x 0.6 x 1: head on, at 45 degrees, turned by 90 degrees, beside it, short of it, from within.
  const Vector3d box(0.4, 0.6, 1);
  EXPECT_NEAR(hit(Shape::box, box, {2, 0.1, 1.2}, {0, 0.1, 1.2}), 1.8 / 2, 1e-12);
  EXPECT_NEAR(hit(Shape::box, box, {1.2, 1, 1}, {-0.8, -1, 1}), 1.0 / 2, 1e-12);  // x = 0.2 where y = 0
  EXPECT_NEAR(hit(Shape::box, box, {2, 0, 1}, {0, 0, 1}, make_pose({0, 0, 1}, rotation_from_yaw_pitch_roll(std::numbers::pi / 2, 0, 0))), 1.7 / 2, 1e-12);
  EXPECT_EQ(hit(Shape::box, box, {2, 0.31, 1}, {-2, 0.31, 1}), -1);
  EXPECT_EQ(hit(Shape::box, box, {2, 0, 1}, {0.21, 0, 1}), -1);
  EXPECT_EQ(hit(Shape::box, box, {0.1, 0, 1}, {2, 0, 1}), 0);
  // A sphere of radius 0.5, by a chord at 0.3 from its middle: half of it is 0.4 long.
  const Vector3d ball(1, 1, 1);
  EXPECT_NEAR(hit(Shape::sphere, ball, {2, 0.3, 1}, {-2, 0.3, 1}), 1.6 / 4, 1e-12);
  EXPECT_EQ(hit(Shape::sphere, ball, {2, 0.51, 1}, {-2, 0.51, 1}), -1);
  EXPECT_EQ(hit(Shape::sphere, ball, {0, 0.3, 1}, {-2, 0.3, 1}), 0);
  // A cylinder of radius 0.5 and height 0.8: its side by the same chord, its lid from above, past its rim.
  const Vector3d drum(1, 1, 0.8);
  EXPECT_NEAR(hit(Shape::cylinder, drum, {2, 0.3, 1.1}, {-2, 0.3, 1.1}), 1.6 / 4, 1e-12);
  EXPECT_NEAR(hit(Shape::cylinder, drum, {0.2, 0.3, 2.4}, {0.2, 0.3, 0.4}), 1.0 / 2, 1e-12);
  EXPECT_NEAR(hit(Shape::cylinder, drum, {1, 0, 2}, {-1, 0, 0}), (2 - 1.4) / 2, 1e-12);  // at 45 degrees: z = 1.4 where x = 0.4
  EXPECT_EQ(hit(Shape::cylinder, drum, {2, 0.3, 1.41}, {-2, 0.3, 1.41}), -1);
  EXPECT_EQ(hit(Shape::cylinder, drum, {0.45, 0.45, 2.4}, {0.45, 0.45, 0.4}), -1);
  EXPECT_EQ(hit(Shape::cylinder, drum, {0.2, 0.3, 1.3}, {0.2, 0.3, 2.4}), 0);
  // The nearest of several.
  EXPECT_NEAR(CollisionWorld(three_shapes()).first_hit({0, -3, 1}, {0, 3, 1}).value_or(-1), 1.75 / 6, 1e-12);
}

// A point's distance is right if the solid's surface point found really is the nearest: bounded by random surface hits.
TEST(CollisionWorld, FirstHitLiesOnTheSurface) {
  const CollisionWorld w(three_shapes());
  Random random(3);
  int hits = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Vector3d p = random_point(random, 1.5), q = random_point(random, 1.5);
    const auto t = w.first_hit(p, q);
    if (!t) {
      for (int i = 0; i <= 50; ++i) EXPECT_FALSE(w.contains(p + (q - p) * (i / 50.0), -1e-6));
      continue;
    }
    ++hits;
    const Vector3d at = p + *t * (q - p);
    EXPECT_TRUE(w.contains(at, 1e-9));
    if (*t > 0) {
      EXPECT_FALSE(w.contains(p + (*t - 1e-6) * (q - p), -1e-9));
      const double before = std::max(0.0, *t - 0.01);
      EXPECT_FALSE(w.contains(p + before * (q - p), -1e-6));
    }
  }
  EXPECT_GT(hits, 100);
}

TEST(CollisionWorld, BoxesAgreeWithSampling) {
  const CollisionWorld w(three_shapes());
  Random random(11);
  int touching = 0, free_boxes = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Vector3d size(random.uniform(0.05, 0.6), random.uniform(0.05, 0.6), random.uniform(0.05, 0.6));
    const Pose X = make_pose(random_point(random, 1.5), rotation_from_yaw_pitch_roll(random.uniform(-3, 3), random.uniform(-1, 1), random.uniform(-1, 1)));
    bool inside = false;
    constexpr int n = 8;
    for (int i = 0; i <= n && !inside; ++i)
      for (int j = 0; j <= n && !inside; ++j)
        for (int k = 0; k <= n && !inside; ++k) {
          const Vector3d p = size.cwiseProduct(Vector3d(i, j, k) / n - Vector3d::Constant(0.5));
          inside = w.contains(X * p, -0.002);
        }
    const bool said = w.box_touches_solid(X, size);
    if (inside) {
      EXPECT_TRUE(said) << trial;
    }
    // No sample within half a cell's diagonal: free for certain.
    if (!inside && said) {
      bool near = false;
      for (int i = 0; i <= n && !near; ++i)
        for (int j = 0; j <= n && !near; ++j)
          for (int k = 0; k <= n && !near; ++k)
            near = w.contains(X * size.cwiseProduct(Vector3d(i, j, k) / n - Vector3d::Constant(0.5)), size.norm() / n / 2);
      EXPECT_TRUE(near) << trial;
    }
    (said ? touching : free_boxes)++;
  }
  EXPECT_GT(touching, 50);
  EXPECT_GT(free_boxes, 50);
  EXPECT_TRUE(w.box_collides(make_pose({2.9, 2, 1}, Eigen::Matrix3d::Identity()), {0.3, 0.3, 0.3}));
  EXPECT_TRUE(w.box_collides(make_pose({2, -2.9, 1}, Eigen::Matrix3d::Identity()), {0.3, 0.3, 0.3}));
  EXPECT_FALSE(w.box_collides(make_pose({2.8, 2, 1}, Eigen::Matrix3d::Identity()), {0.3, 0.3, 0.3}));
}

}  // namespace
}  // namespace periplus::scene
