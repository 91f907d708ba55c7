#include "services/vision_server/normals.h"

#include <gtest/gtest.h>

#include <cmath>

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
