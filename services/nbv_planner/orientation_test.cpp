#include "services/nbv_planner/orientation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/voxel/coarsen.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;
const StereoRig kRig{Pinhole::from_vertical_fov(640, 480, 25 * kRadiansPerDegree), 0.144};

TEST(Orientation, WindowIsWhatBothEyesProject) {
  const PairWindow window = PairWindow::of(kRig, {});
  Random random(5);
  int inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const Angles a{random.uniform(-3, 3), random.uniform(-0.4, 1), random.uniform(-0.3, 0.3)};
    const Pose left = left_eye({1, 2, 1.1}, a, kRig.baseline);
    EXPECT_NEAR((middle_of_eyes(left, kRig.baseline) - Eigen::Vector3d(1, 2, 1.1)).norm(), 0, 1e-12);
    const Eigen::Vector3d p = left * Eigen::Vector3d(random.uniform(-0.4, 0.6), random.uniform(-0.5, 0.5), random.uniform(0.3, 3));
    const auto sees = [&](const Pose& X) {
      const Eigen::Vector3d q = X.inverse() * p;
      if (q.z() < 0.6 || q.z() > 2.5) return false;
      const Eigen::Vector2d px = kRig.camera.project(q);
      return px.x() >= -0.5 && px.x() <= 639.5 && px.y() >= -0.5 && px.y() <= 479.5;
    };
    const bool both = sees(left) && sees(left * Pose(Eigen::Translation3d(kRig.baseline, 0, 0)));
    VisibleList one;
    one.add((p - Eigen::Vector3d(1, 2, 1.1)).cast<float>());
    EXPECT_EQ(one.sum(window.planes(a.yaw, a.pitch, a.roll)), both) << i;
    inside += both;
  }
  EXPECT_GT(inside, 400);
}

// 200 points to the left, 100 to the right and below.
VisibleList two_clusters() {
  Random random(6);
  VisibleList points;
  for (int i = 0; i < 300; ++i) {
    const bool left = i % 3 != 0;
    const Pose X = look_along({0, 0, 0}, left ? 0.6 : -0.6, left ? 0 : 0.9);
    points.add((X * Eigen::Vector3d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 1.2)).cast<float>());
  }
  return points;
}

TEST(Orientation, PrefersTheGreaterClusterWithinTheLimits) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  const OrientationCost cost(evaluator);
  const VisibleList points = two_clusters();
  const auto best = [&](const robot::ViewLimits& limits) {
    OrientationSearch search(PairWindow::of(kRig, {}), limits);
    return search.compass(points, cost, search.histogram(points, cost, {1, 0, 0}), 3 * kRadiansPerDegree, 1 * kRadiansPerDegree);
  };
  robot::ViewLimits limits;
  limits.pitch_min = -0.4;
  limits.pitch_max = 1.0;
  const Aim o = best(limits);
  EXPECT_EQ(o.value, 200);
  EXPECT_NEAR(o.angles.yaw, 0.6, 0.2);
  // With the pitch or the yaw bounded so that the left cluster is out of sight, the right one.
  limits.pitch_min = 0.7;
  EXPECT_EQ(best(limits).value, 100);
  EXPECT_GE(best(limits).angles.pitch, 0.7);
  limits.pitch_min = -0.4;
  limits.yaw_min = -2;
  limits.yaw_max = -0.3;
  EXPECT_EQ(best(limits).value, 100);
  EXPECT_LE(best(limits).angles.yaw, -0.3 + 1e-12);

  OrientationSearch search(PairWindow::of(kRig, {}), {});
  EXPECT_NEAR(search.histogram(VisibleList(), cost, {0, 1, 0}).angles.yaw, std::numbers::pi / 2, 1e-9);
}

TEST(Orientation, HistogramComesNearTheBestOfAFineSweep) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  const OrientationCost cost(evaluator);
  Random random(9);
  for (int trial = 0; trial < 12; ++trial) {
    VisibleList points;
    for (int cluster = 0; cluster < 4; ++cluster) {
      const double yaw = random.uniform(-3.1, 3.1), pitch = random.uniform(-0.3, 0.9), spread = random.uniform(0.05, 0.4);
      for (int i = 0; i < 200; ++i) {
        const Pose X = look_along({0, 0, 0}, yaw + random.normal() * spread, pitch + random.normal() * spread);
        points.add((X * Eigen::Vector3d(0, 0, random.uniform(0.7, 2.2))).cast<float>());
      }
    }
    robot::ViewLimits limits;
    OrientationSearch search(PairWindow::of(kRig, {}), limits);
    double most = 0;
    for (double yaw = -std::numbers::pi; yaw < std::numbers::pi; yaw += 0.02)
      for (double pitch = limits.pitch_min; pitch <= limits.pitch_max; pitch += 0.02) most = std::max(most, search.evaluate(points, cost, {yaw, pitch, 0}).value);
    const Aim histogram = search.histogram(points, cost, {1, 0, 0});
    const Aim found = search.compass(points, cost, histogram, 3 * kRadiansPerDegree, 0.7 * kRadiansPerDegree);
    EXPECT_GE(found.value, histogram.value);
    EXPECT_GE(found.value, 0.9 * most) << trial;
    EXPECT_GE(search.kicks(points, cost, found, 0.9 * kRadiansPerDegree).value, found.value);
  }
}

TEST(Orientation, RollIsUsedWhereItIsAllowed) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  const OrientationCost cost(evaluator);
  VisibleList points;  // in a row: longer than the image is wide, not longer than its diagonal
  for (int i = -20; i <= 20; ++i) points.add(Eigen::Vector3f(1.2f, 0.017f * static_cast<float>(i), 0));
  robot::ViewLimits limits;
  OrientationSearch level(PairWindow::of(kRig, {}), limits);
  limits.roll_max = 0.9;
  OrientationSearch rolling(PairWindow::of(kRig, {}), limits);
  const Aim a = level.kicks(points, cost, level.evaluate(points, cost, {0, 0, 0}), 0.01);
  const Aim b = rolling.kicks(points, cost, rolling.evaluate(points, cost, {0, 0, 0}), 0.01);
  EXPECT_EQ(a.angles.roll, 0);
  EXPECT_NE(b.angles.roll, 0);
  EXPECT_GT(b.value, a.value);
}

TEST(Orientation, ListOfARenderingIsWhatThePairCounts) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  const PairWindow window = PairWindow::of(s.rig, evaluator.settings().pair);
  Evaluator::Workspace w;
  for (double y : {-0.6, 0.0, 0.5}) {
    const Eigen::Vector3d p(1.1, y, 1.2), d = Eigen::Vector3d(0.15, 0, 1.1) - p;
    const Angles a{std::atan2(d.y(), d.x()), std::atan2(-d.z(), std::hypot(d.x(), d.y())), 0};
    const Evaluation e = evaluator.evaluate(left_eye(p, a, s.rig.baseline), w);
    const voxel::VisibilityResult &left = w.visibility.left, &right = w.visibility.right;
    VisibleList list;
    list.take_both({left.unknown.begin(), left.unknown.end()}, {right.unknown.begin(), right.unknown.end()}, 1, p, evaluator);
    EXPECT_GT(e.gain.voxels, 200);
    EXPECT_NEAR(list.sum(window.planes(a.yaw, a.pitch)), e.gain.voxels, 3);  // those with few pixels are in the list
    EXPECT_NEAR((list.mean(window.planes(a.yaw, a.pitch)) + p - Eigen::Vector3d(0.14, 0, 1.1)).norm(), 0, 0.02);
  }
}

TEST(Orientation, LevelIsTriedWhereStepsWouldMissIt) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  const OrientationCost cost(evaluator);
  const PairWindow window = PairWindow::of(kRig, {});
  VisibleList points;  // two rows just inside the image's upper and lower bounds when the camera is level
  const float edge = 1.2f * static_cast<float>(window.tan_vertical) * 0.9999f;
  for (int i = -10; i <= 10; ++i) {
    for (float z : {-edge, edge}) points.add(Eigen::Vector3f(1.2f, 0.01f * static_cast<float>(i), z));
  }
  OrientationSearch search(window, {});
  const Aim found = search.compass(points, cost, search.evaluate(points, cost, {0, 0.031, 0}), 0.02, 0.005);
  EXPECT_EQ(found.angles.pitch, 0);
  EXPECT_EQ(found.value, 42);
}

TEST(Orientation, ListOfACoarseSceneIsWorthTheSame) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  const PairWindow window = PairWindow::of(s.rig, evaluator.settings().pair);
  const voxel::VisibilityScene coarse(voxel::coarsen(*s.grid));
  voxel::VisibilityWorkspace w;
  const Eigen::Vector3d p(1.2, 0, 1.1);
  const Angles a{std::numbers::pi, 0, 0};
  const auto value = [&](const ListScene& of) {
    of.scene().evaluate(left_eye(p, a, 0), s.rig.camera, {0, 10, 0, true}, w, w.left);
    VisibleList list;
    list.take({w.left.unknown.begin(), w.left.unknown.end()}, 1, p, of);
    return list.sum(window.planes(a.yaw, a.pitch));
  };
  const double fine = value(evaluator);
  EXPECT_GT(fine, 200);
  EXPECT_NEAR(value({evaluator, coarse}), fine, 0.15 * fine);  // its bounds are rounded to the coarse voxels
}

TEST(Orientation, ForbiddenPosesAndWeightsCount) {
  Situation s = testing::patch_at_plus_x();
  const VisibleList points = two_clusters();
  robot::ViewLimits limits;
  OrientationSearch search(PairWindow::of(kRig, {}), limits);
  const Eigen::Vector3d p(1, 2, 1.1);
  s.forbidden.push_back(left_eye(p, {0.6, 0, 0}, kRig.baseline));
  const Evaluator evaluator(s, {}, {});
  OrientationCost cost(evaluator);
  cost.place(p, {}, 1, 150, evaluator);
  const Aim o = search.compass(points, cost, search.histogram(points, cost, {1, 0, 0}), 3 * kRadiansPerDegree, 1 * kRadiansPerDegree);
  EXPECT_FALSE(evaluator.constraints().forbidden(left_eye(p, o.angles, kRig.baseline)));
  VisibleList heavy;
  heavy.add({1.2f, 0, 0}, 0.25f);
  heavy.add({1.3f, 0, 0}, 2);
  EXPECT_EQ(heavy.sum(PairWindow::of(kRig, {}).planes(0, 0)), 2.25);
}

}  // namespace
}  // namespace periplus::nbv
