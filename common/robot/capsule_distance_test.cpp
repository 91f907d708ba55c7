#include "common/robot/capsule_distance.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace periplus::robot {

using Eigen::Vector3d;

TEST(CapsuleDistance, KnownCases) {
  EXPECT_NEAR(closest_points({-1, 0, 0}, {1, 0, 0}, {0, -1, 2}, {0, 1, 2}).distance, 2, 1e-12);          // crossing
  EXPECT_NEAR(closest_points({0, 0, 0}, {1, 0, 0}, {3, 4, 0}, {3, 9, 0}).distance, std::sqrt(20.0), 1e-12);  // end to end
  EXPECT_NEAR(closest_points({0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {9, 1, 0}).distance, 1, 1e-12);          // parallel
  EXPECT_NEAR(closest_points({0, 0, 0}, {0, 0, 0}, {-1, 3, 0}, {1, 3, 0}).distance, 3, 1e-12);           // point and segment
  EXPECT_NEAR(closest_points({0, 0, 0}, {0, 0, 0}, {0, 3, 4}, {0, 3, 4}).distance, 5, 1e-12);            // two points
}

TEST(CapsuleDistance, AgreesWithDenseSampling) {
  Random random(4);
  const auto point = [&] { return Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)); };
  for (int trial = 0; trial < 100; ++trial) {
    const Vector3d a1 = point(), b1 = point(), a2 = point(), b2 = point();
    double least = 1e9;
    constexpr int n = 200;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        least = std::min(least, (a1 + (b1 - a1) * i / n - a2 - (b2 - a2) * j / n).norm());
      }
    }
    const ClosestPoints found = closest_points(a1, b1, a2, b2);
    EXPECT_LE(found.distance, least + 1e-12);
    EXPECT_NEAR(found.distance, least, 0.02);
    EXPECT_NEAR((found.on_first - found.on_second).norm(), found.distance, 1e-12);
  }
}

}  // namespace periplus::robot
