#include "common/voxel/occluder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"

namespace periplus::voxel {
namespace {

// Extent of the points along a direction.
double reach(const Occluder& o, const Eigen::Vector3d& direction) {
  double most = -1e9;
  for (const auto& p : o.points_W) most = std::max(most, p.dot(direction));
  return most;
}

TEST(Occluder, ABoxHasItsCorners) {
  const Pose X_WS = make_pose({1, 2, 3}, rotation_from_yaw_pitch_roll(0.5, 0.2, -0.1));
  const Occluder box = Occluder::box(X_WS, {0.2, 0.4, 0.6});
  ASSERT_EQ(box.points_W.size(), 8u);
  for (const auto& p : box.points_W) EXPECT_TRUE((X_WS.inverse() * p).cwiseAbs().isApprox(Eigen::Vector3d(0.1, 0.2, 0.3), 1e-12));
}

TEST(Occluder, ACylinderIsAPrismOfTheSameCrossSection) {
  const Occluder cylinder = Occluder::cylinder(make_pose({0, 0, 1}, Eigen::Matrix3d::Identity()), 0.5, 2);
  double area = 0;
  Eigen::Vector3d before = cylinder.points_W[cylinder.points_W.size() - 2];
  for (std::size_t i = 0; i < cylinder.points_W.size(); i += 2) {  // the lower ring
    const Eigen::Vector3d& p = cylinder.points_W[i];
    area += (before.x() * p.y() - p.x() * before.y()) / 2;
    before = p;
    EXPECT_NEAR(p.z(), 0, 1e-12);
  }
  EXPECT_NEAR(area, std::numbers::pi * 0.25 * 0.25, 1e-9);
  EXPECT_NEAR(reach(cylinder, Eigen::Vector3d::UnitZ()), 2, 1e-12);
}

TEST(Occluder, ASphereDeviatesByLessThanHalfAPercent) {
  const Eigen::Vector3d middle(0.3, -0.2, 1);
  const Occluder sphere = Occluder::sphere(middle, 2);
  for (int i = 0; i < 500; ++i) {
    const double z = -1 + 2 * (i + 0.5) / 500, angle = i * 2.4, r = std::sqrt(1 - z * z);
    const Eigen::Vector3d d(r * std::cos(angle), r * std::sin(angle), z);
    EXPECT_NEAR(reach(sphere, d) - middle.dot(d), 1, 0.005);
  }
}

TEST(Occluder, AMeshIsItsTriangles) {
  const std::vector<Eigen::Vector3d> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto triangles = Occluder::mesh(vertices, {{0, 1, 2}, {1, 2, 3}});
  ASSERT_EQ(triangles.size(), 2u);
  EXPECT_EQ(triangles[1].points_W, (std::vector<Eigen::Vector3d>{vertices[1], vertices[2], vertices[3]}));
  EXPECT_THROW(Occluder::mesh(vertices, {{0, 1, 4}}), Error);
  EXPECT_THROW(Occluder::mesh(vertices, {{0, -1, 2}}), Error);
}

}  // namespace
}  // namespace periplus::voxel
