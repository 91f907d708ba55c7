#include "common/mesh/triangle_tree.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::mesh {
namespace {

using Eigen::Vector3d;

TEST(TriangleTree, DistancesToAKnownBox) {
  const TriangleTree tree(make_box({1, 2, 3}, 1));
  EXPECT_NEAR(tree.closest({1.5, 0, 0}).distance, 1.0, 1e-12);
  EXPECT_NEAR(tree.closest({0.4, 0, 0}).distance, 0.1, 1e-12);  // from inside
  EXPECT_NEAR(tree.closest({1.5, 2, 0}).distance, std::sqrt(2.0), 1e-12);
  EXPECT_NEAR((tree.closest({0, 0, 9}).point - Vector3d(0, 0, 1.5)).norm(), 0, 1e-12);
}

// Against a search through all triangles, each as a tree of its own.
TEST(TriangleTree, AgreesWithExhaustiveSearch) {
  TriangleMesh m = make_sphere(1, 1);
  Random random(4);
  for (Vector3d& p : m.vertices) p *= random.uniform(0.7, 1.3);
  const TriangleTree tree(m);
  std::vector<TriangleTree> single;
  for (const auto& t : m.triangles) {
    TriangleMesh one;
    for (int k = 0; k < 3; ++k) one.vertices.push_back(m.vertices[static_cast<std::size_t>(t[k])]);
    one.triangles.emplace_back(0, 1, 2);
    single.emplace_back(one);
  }
  int hits = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Vector3d p(random.normal(), random.normal(), random.normal());
    const Vector3d d = 0.3 * Vector3d(random.normal(), random.normal(), random.normal()) - p;
    double nearest = 1e9, first = 1e9;
    for (const auto& s : single) {
      nearest = std::min(nearest, s.closest(p).distance);
      if (const auto hit = s.ray(p, d)) first = std::min(first, hit->t);
    }
    EXPECT_NEAR(tree.closest(p).distance, nearest, 1e-12);
    const auto hit = tree.ray(p, d);
    EXPECT_EQ(hit.has_value(), first < 1e9);
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->t, first, 1e-12);
    EXPECT_FALSE(tree.ray(p, d, first * 0.999).has_value());
    EXPECT_NEAR(tree.closest(p + hit->t * d).distance, 0, 1e-9);
  }
  EXPECT_GT(hits, 10);
}

TEST(TriangleTree, SegmentsBesideAKnownBox) {
  const TriangleTree tree(make_box({1, 2, 3}, 1));
  // Beside a face and parallel to it, across an edge, off a corner, through, within, a point.
  EXPECT_NEAR(tree.closest_to_segment({1.5, -0.4, 0}, {1.5, 0.3, 0.2}).distance, 1.0, 1e-12);
  const auto across = tree.closest_to_segment({2, 0, 0.3}, {0, 3, 0.3});  // x / 2 + y / 3 = 1 past the edge at (0.5, 1)
  EXPECT_NEAR(across.distance, (1 - 0.5 / 2 - 1.0 / 3) / std::hypot(1 / 2.0, 1 / 3.0), 1e-12);
  EXPECT_NEAR((across.point - Vector3d(0.5, 1, 0.3)).norm(), 0, 1e-9);
  EXPECT_NEAR(tree.closest_to_segment({0.8, 1.4, 1.5}, {2, 3, 4}).distance, 0.5, 1e-12);
  const auto through = tree.closest_to_segment({-2, 0.1, 0.2}, {2, 0.1, 0.2});
  EXPECT_NEAR(through.distance, 0, 1e-12);
  EXPECT_NEAR(std::abs(through.t - 0.5), 0.125, 1e-12);
  EXPECT_NEAR(tree.closest_to_segment({0.3, 0, 0}, {0.1, 0, 0}).distance, 0.2, 1e-12);
  EXPECT_NEAR(tree.closest_to_segment({0.3, 0, 0}, {0.1, 0, 0}).t, 0, 1e-12);
  EXPECT_NEAR(tree.closest_to_segment({0, 0, 9}, {0, 0, 9}).distance, 7.5, 1e-12);
}

// Never more than at any point of the segment, and no less than what the samples between can hide.
TEST(TriangleTree, SegmentsAgreeWithSampling) {
  TriangleMesh m = make_sphere(1, 1);
  Random random(6);
  for (Vector3d& p : m.vertices) p *= random.uniform(0.7, 1.3);
  const TriangleTree tree(m);
  int beside = 0, through = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Vector3d a(random.normal(), random.normal(), random.normal()), b = a + Vector3d(random.normal(), random.normal(), random.normal());
    const auto c = tree.closest_to_segment(a, b);
    EXPECT_NEAR((a + c.t * (b - a) - c.point).norm(), c.distance, 1e-12);
    EXPECT_NEAR(tree.closest(c.point).distance, 0, 1e-9);
    double least = 1e9;
    for (int i = 0; i <= 200; ++i) least = std::min(least, tree.closest(a + (b - a) * (i / 200.0)).distance);
    EXPECT_LE(c.distance, least + 1e-12);
    EXPECT_GE(c.distance, least - (b - a).norm() / 400);
    (c.distance > 0.01 ? beside : through) += 1;
  }
  EXPECT_GT(beside, 30);
  EXPECT_GT(through, 10);
}

// Planes of the grid of faces, in which the tree's boxes end too: a ray within them meets the box all the same.
TEST(TriangleTree, RayWithinTheFacesOfBoxes) {
  const TriangleTree tree(make_box({0.02, 2, 2}, 1));
  for (const double y : {-0.75, -0.5, -0.25, 0.0, 0.1, 0.25, 1.0})
    for (const double z : {-1.0, -0.5, -0.25, 0.0, 0.25, 0.7}) {
      const auto hit = tree.ray({1, y, z}, {-1, 0, 0});
      ASSERT_TRUE(hit.has_value()) << y << " " << z;
      EXPECT_NEAR(hit->t, 0.99, 1e-12);
      EXPECT_TRUE(tree.ray({1, y - 0.01, z}, {-1, y > 0 ? -0.001 : 0.001, 0}).has_value() || y - 0.01 < -1) << y << " " << z;
    }
}

TEST(TriangleTree, RayAlongAnAxis) {
  const TriangleTree tree(make_box({1, 1, 1}, 1));
  const auto hit = tree.ray({-3, 0.1, 0.2}, {1, 0, 0});
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->t, 2.5, 1e-12);
  EXPECT_FALSE(tree.ray({-3, 0.1, 0.2}, {-1, 0, 0}).has_value());
  EXPECT_THROW(TriangleTree(TriangleMesh{}), Error);
}

}  // namespace
}  // namespace periplus::mesh
