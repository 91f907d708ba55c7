#include "services/nbv_planner/orientation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

TEST(Orientation, WindowIsWhatBothEyesProject) {
  const StereoRig rig{Pinhole::from_vertical_fov(640, 480, 25 * kRadiansPerDegree), 0.144};
  const PairWindow window = PairWindow::of(rig, {});
  Random random(5);
  int inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const double yaw = random.uniform(-3, 3), pitch = random.uniform(-0.4, 1);
    const Pose left = left_eye({1, 2, 1.1}, yaw, pitch, rig.baseline);
    const Eigen::Vector3d p = left * Eigen::Vector3d(random.uniform(-0.4, 0.6), random.uniform(-0.5, 0.5), random.uniform(0.3, 3));
    const auto sees = [&](const Pose& X) {
      const Eigen::Vector3d q = X.inverse() * p;
      if (q.z() < 0.6 || q.z() > 2.5) return false;
      const Eigen::Vector2d px = rig.camera.project(q);
      return px.x() >= -0.5 && px.x() <= 639.5 && px.y() >= -0.5 && px.y() <= 479.5;
    };
    const bool both = sees(left) && sees(left * Pose(Eigen::Translation3d(rig.baseline, 0, 0)));
    EXPECT_EQ(window.count({(p - Eigen::Vector3d(1, 2, 1.1)).cast<float>()}, yaw, pitch), both) << i;
    inside += both;
  }
  EXPECT_GT(inside, 400);
}

TEST(Orientation, PrefersTheGreaterClusterAndKeepsThePitch) {
  const StereoRig rig{Pinhole::from_vertical_fov(640, 480, 25 * kRadiansPerDegree), 0.144};
  const PairWindow window = PairWindow::of(rig, {});
  Random random(6);
  Directions points;
  for (int i = 0; i < 300; ++i) {  // 200 points to the left, 100 to the right and below
    const bool left = i % 3 != 0;
    const Pose X = look_along({0, 0, 0}, left ? 0.6 : -0.6, left ? 0 : 0.9);
    points.push_back((X * Eigen::Vector3d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 1.2)).cast<float>());
  }
  const Orientation o = choose_orientation(window, points, {1, 0, 0}, -0.4, 1.0);
  EXPECT_EQ(o.count, 200);
  EXPECT_NEAR(o.yaw, 0.6, 0.2);
  EXPECT_EQ(window.count(points, o.yaw, o.pitch), o.count);
  // With the pitch bounded so that the left cluster is out of sight, the right one.
  const Orientation low = choose_orientation(window, points, {1, 0, 0}, 0.7, 1.0);
  EXPECT_EQ(low.count, 100);
  EXPECT_GE(low.pitch, 0.7);
  const Orientation none = choose_orientation(window, {}, {0, 1, 0}, -0.4, 1.0);
  EXPECT_NEAR(none.yaw, std::numbers::pi / 2, 1e-9);
}

TEST(Orientation, EstimateFromOneRenderingMatchesThePair) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  Evaluator::Workspace w;
  for (double y : {-0.6, 0.0, 0.5}) {
    const Sample sample = look_around(evaluator, {1.1, y, 1.2}, w.visibility);
    const Evaluation e = evaluator.evaluate(sample.X_WC, w);
    EXPECT_GT(e.gain.voxels, 200);
    EXPECT_NEAR(sample.voxels, e.gain.voxels, 15);
  }
}

}  // namespace
}  // namespace periplus::nbv
