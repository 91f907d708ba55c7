#include "common/geometry/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include "common/core/random.h"

namespace periplus {
namespace {

TEST(Pose, YawPitchRollRoundTrip) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d ypr(random.uniform(-3, 3), random.uniform(-1.5, 1.5), random.uniform(-3, 3));
    EXPECT_TRUE(yaw_pitch_roll(rotation_from_yaw_pitch_roll(ypr[0], ypr[1], ypr[2])).isApprox(ypr, 1e-9));
  }
}

TEST(Pose, LookAtPutsTheTargetOnTheAxisAndKeepsTheImageUpright) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d p(random.uniform(-2, 2), random.uniform(-2, 2), 1.2), t(0.1, 0.2, 0.9);
    const Pose X = look_at(p, t);
    const Eigen::Vector3d q = X.inverse() * t;
    EXPECT_NEAR(q.x(), 0, 1e-12);
    EXPECT_NEAR(q.y(), 0, 1e-12);
    EXPECT_NEAR(q.z(), (t - p).norm(), 1e-12);
    EXPECT_NEAR(X.linear()(2, 0), 0, 1e-12);  // image x axis is level
    EXPECT_LT(X.linear()(2, 1), 0);           // image y axis points down
    const Eigen::Vector3d ypr = camera_yaw_pitch_roll(X);
    EXPECT_TRUE(look_along(p, ypr[0], ypr[1], ypr[2]).isApprox(X, 1e-12));
  }
}

TEST(Pose2, ComposeWithInverseIsIdentity) {
  const Pose2 a{1, 2, 3}, e = compose(a, inverse(a));
  EXPECT_NEAR(e.x, 0, 1e-12);
  EXPECT_NEAR(e.y, 0, 1e-12);
  EXPECT_NEAR(e.yaw, 0, 1e-12);
  const Pose2 b{-0.3, 0.2, -2.5}, c = compose(a, b);
  EXPECT_TRUE(to_pose(c).isApprox(to_pose(a) * to_pose(b), 1e-12));
}

TEST(Pose2, TheMiddleFacesTheShorterWayRound) {
  const Pose2 m = middle({1, 0, 3}, {3, 2, -3});
  EXPECT_DOUBLE_EQ(m.x, 2);
  EXPECT_DOUBLE_EQ(m.y, 1);
  EXPECT_NEAR(std::abs(m.yaw), std::numbers::pi, 1e-12);
  EXPECT_NEAR(mean_yaw(3, -3), std::numbers::pi, 1e-12);
  EXPECT_NEAR(mean_yaw(-3, 3), -std::numbers::pi, 1e-12);
  EXPECT_DOUBLE_EQ(mean_yaw(0.2, 0.6), 0.4);
}

}  // namespace
}  // namespace periplus
