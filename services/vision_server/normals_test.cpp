#include "services/vision_server/normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/core/random.h"

namespace periplus::vision {
namespace {

const Pinhole kCloseCamera = Pinhole::from_vertical_fov(160, 120, 0.436);

// Depth of the plane n . p = offset.
ImageF plane(const Eigen::Vector3d& n, double offset, double noise = 0) {
  ImageF depth(160, 120);
  Random random(3);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x)
      depth.at(x, y) = static_cast<float>(offset / n.dot(kCloseCamera.back_project(x, y, 1)) + noise * random.normal());
  return depth;
}

TEST(Normals, OfAPlaneFaceTheCamera) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.5, -0.3, 1).normalized();
  const auto found = normal_at(plane(n, 1), kCloseCamera, 80, 60, 5, 0.1);
  ASSERT_TRUE(found);
  EXPECT_NEAR((*found + n).norm(), 0, 1e-3);
  const auto noisy = normal_at(plane(n, 1, 0.001), kCloseCamera, 80, 60, 10, 0.1);
  ASSERT_TRUE(noisy);
  EXPECT_LT(std::acos(std::min(1.0, -noisy->dot(n))), 0.15);
}

// Depth as stereo gives it at 1.2 m: disparities wrong by 0.15 px (1.4 mm), alike within the matcher's blocks of 5.
TEST(Normals, AreGoodToTenDegreesWithTheNoiseOfStereo) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.2, 1).normalized();
  const Pinhole eye{160, 120, 1082, 1082, 79.5, 59.5};  // the middle of the robot's
  Random random(7);
  ImageF noise(160, 120);
  for (float& v : noise.data) v = static_cast<float>(random.normal());
  ImageF depth(160, 120);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) depth.at(x, y) = static_cast<float>(1.2 * n.z() / n.dot(eye.back_project(x, y, 1)));
  for (int y = 2; y < 118; ++y)
    for (int x = 2; x < 158; ++x) {
      double sum = 0;
      for (int i = 0; i < 25; ++i) sum += noise.at(x + i % 5 - 2, y + i / 5 - 2);
      depth.at(x, y) += static_cast<float>(0.0014 * sum / 5);
    }
  std::vector<double> angles;
  for (int v = 20; v < 100; v += 4)
    for (int u = 20; u < 140; u += 4) {
      const auto found = normal_at(depth, eye, u, v, kNormalHalfWindow, kNormalReach);
      if (found) angles.push_back(std::acos(std::clamp(-found->dot(n), -1.0, 1.0)) * 180 / M_PI);
    }
  EXPECT_GT(angles.size(), 570u);  // of 600
  std::nth_element(angles.begin(), angles.begin() + static_cast<long>(angles.size()) / 2, angles.end());
  EXPECT_LT(angles[angles.size() / 2], 10);
}

TEST(Normals, TheFarSideOfAnEdgeDoesNotBendThem) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.2, 0, 1).normalized();
  ImageF depth = plane(n, 1);
  for (int y = 0; y < 120; ++y)
    for (int x = 83; x < 160; ++x) depth.at(x, y) = 3;
  const auto found = normal_at(depth, kCloseCamera, 80, 60, 5, 0.05);
  ASSERT_TRUE(found);
  EXPECT_NEAR((*found + n).norm(), 0, 1e-3);
}

TEST(Normals, AreUnknownWithoutEnoughDepth) {
  ImageF depth = plane({0, 0, 1}, 1);
  EXPECT_TRUE(normal_at(depth, kCloseCamera, 80, 60, 5, 0.05));
  EXPECT_FALSE(normal_at(depth, kCloseCamera, -1, 60, 5, 0.05));
  EXPECT_FALSE(normal_at(depth, kCloseCamera, 160, 60, 5, 0.05));
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x)
      if ((x + y) % 4) depth.at(x, y) = 0;
  EXPECT_FALSE(normal_at(depth, kCloseCamera, 80, 60, 5, 0.05));  // a quarter is too few
  EXPECT_FALSE(normal_at(depth, kCloseCamera, 81, 60, 5, 0.05));  // no depth here
}

}  // namespace
}  // namespace periplus::vision
