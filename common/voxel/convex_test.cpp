#include "common/voxel/convex.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/core/random.h"

namespace periplus::voxel {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

TEST(ConvexHull, HoldsAllPointsAndTurnsLeftAtEachCorner) {
  Random random(5);
  for (int n = 3; n < 60; ++n) {
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < n; ++i) points.emplace_back(random.uniform(-3, 3), random.uniform(-1, 1));
    const auto hull = convex_hull(points);
    ASSERT_GE(hull.size(), 3u);
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const Eigen::Vector2d& a = hull[i];
      const Eigen::Vector2d &b = hull[(i + 1) % hull.size()], &c = hull[(i + 2) % hull.size()];
      EXPECT_GT(cross(b - a, c - b), 0);
      EXPECT_NE(std::find(points.begin(), points.end(), a), points.end());
      for (const auto& p : points) EXPECT_GE(cross(b - a, p - a), -1e-12);
    }
  }
}

TEST(ConvexHull, OfPointsOnALineIsItsEnds) {
  const auto hull = convex_hull({{0, 0}, {2, 2}, {1, 1}, {0.5, 0.5}});
  EXPECT_EQ(hull.size(), 2u);
}

// A box of 2 x 2 x 2 about the origin, cut by planes at any distance and slant: no point beyond the plane, and the extent along its normal
// that of the box where the plane leaves it.
TEST(Clip, KeepsTheBodyOnOneSideOfAPlane) {
  Points box;
  for (int c = 0; c < 8; ++c) box.emplace_back(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
  Random random(6);
  int cut = 0;
  for (int n = 0; n < 500; ++n) {
    const Eigen::Vector3d normal = Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)).normalized();
    const double at = random.uniform(-2, 2), reach = normal.cwiseAbs().sum();
    const Points part = clip(box, [&](const Eigen::Vector3d& p) { return normal.dot(p) - at; });
    EXPECT_EQ(part.empty(), at > reach);
    double least = 1e9, most = -1e9;
    for (const auto& p : part) {
      least = std::min(least, normal.dot(p));
      most = std::max(most, normal.dot(p));
      EXPECT_LE(p.cwiseAbs().maxCoeff(), 1 + 1e-12);
    }
    if (part.empty()) continue;
    EXPECT_NEAR(most, reach, 1e-12);
    EXPECT_NEAR(least, std::max(at, -reach), 1e-12);
    cut += at > -reach;
  }
  EXPECT_GT(cut, 200);
}

}  // namespace
}  // namespace periplus::voxel
