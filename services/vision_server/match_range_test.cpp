#include "services/vision_server/match_range.h"

#include <gtest/gtest.h>

namespace periplus::vision {
namespace {

const StereoRig kRobotRig{Pinhole::from_vertical_fov(640, 480, 0.436332), 0.144};

object_model::ObjectBox box_at(const Eigen::Vector3d& p, double side) {
  object_model::ObjectBox box;
  box.X_WB.translation() = p;
  box.size.setConstant(side);
  return box;
}

TEST(DepthRange, GoesFromTheBoxToTheFarthestCornerOfTheRoom) {
  scene::Scene scene;  // 6 x 6 x 2.8 m
  const Pose X_WC = look_at({-1.2, 0, 1.4}, {3, 0, 1.4});
  const DepthRange r = depth_range(kRobotRig, X_WC, box_at({0, 0, 1.4}, 0.4), &scene, 0.4, 6.5);
  EXPECT_NEAR(r.nearest, 1.0 - 0.02, 1e-9);
  EXPECT_NEAR(r.farthest, 4.2 + 0.02, 1e-9);
}

TEST(DepthRange, WithoutARoomItUsesTheDefault) {
  const DepthRange r = depth_range(kRobotRig, look_at({-1.2, 0, 1.4}, {0, 0, 1.4}), box_at({0, 0, 1.4}, 0.4), nullptr, 0.4, 6.5);
  EXPECT_NEAR(r.farthest, 6.5, 0.03);
}

TEST(DepthRange, ASolidInThePictureBringsTheNearEndCloserAndOneOutsideDoesNot) {
  scene::Scene scene;
  scene::Solid post;
  post.size = {0.1, 0.1, 0.4};
  post.X_WS.translation() = Eigen::Vector3d(-0.6, 0, 1.4);
  scene.solids.push_back(post);
  const Pose X_WC = look_at({-1.2, 0, 1.4}, {3, 0, 1.4});
  EXPECT_NEAR(depth_range(kRobotRig, X_WC, box_at({0, 0, 1.4}, 0.4), &scene, 0.4, 6.5).nearest, 0.55 - 0.02, 1e-9);
  scene.solids[0].X_WS.translation().y() = 1;
  EXPECT_NEAR(depth_range(kRobotRig, X_WC, box_at({0, 0, 1.4}, 0.4), &scene, 0.4, 6.5).nearest, 1.0 - 0.02, 1e-9);
}

TEST(DepthRange, TheFloorInThePictureCounts) {
  scene::Scene scene;
  const Pose X_WC = look_along({-1.2, 0, 1.0}, 0, 1.0);
  const Eigen::Vector3d ray = X_WC.linear() * kRobotRig.camera.back_project(320, 479, 1);
  const DepthRange r = depth_range(kRobotRig, X_WC, box_at({0.2, 0, 0.1}, 0.1), &scene, 0.4, 6.5);
  EXPECT_NEAR(r.nearest, -1.0 / ray.z() - 0.02, 0.01);
}

TEST(DepthRange, RefusesABoxBehindTheCamera) {
  EXPECT_THROW(depth_range(kRobotRig, look_at({0, 0, 1}, {1, 0, 1}), box_at({-2, 0, 1}, 0.4), nullptr, 0.4, 6.5), Error);
}

TEST(DisparityRange, HoldsBothEndsAndIsAMultipleOfSixteen) {
  for (double near : {0.5, 0.8, 1.3}) {
    const DisparityRange r = disparity_range(kRobotRig, {near, 5.0});
    EXPECT_EQ(r.count % 16, 0);
    EXPECT_LT(r.least, kRobotRig.disparity(5.0));
    EXPECT_GT(r.least + r.count, kRobotRig.disparity(near) + 1);
    EXPECT_LT(r.least + r.count, kRobotRig.disparity(near) + 20);
  }
}

TEST(DisparityRange, EndsWhereTheMatcherDoesAndRefusesABoxBeyond) {
  const StereoRig large{Pinhole::from_vertical_fov(8192, 6144, 0.436332), 0.144};
  const double limit = large.depth(kMostDisparity);
  const DisparityRange r = disparity_range(large, {0.4, 5.0, limit + 0.01});  // the floor, say, lies nearer
  EXPECT_LE(r.least + r.count, kMostDisparity + 1);
  EXPECT_GT(r.least + r.count, kMostDisparity - 16);
  EXPECT_LT(r.least, large.disparity(5.0));
  EXPECT_THROW(disparity_range(large, {0.4, 5.0, limit - 0.01}), Error);
  EXPECT_NEAR(depth_range(large, look_at({-1.2, 0, 1.4}, {0, 0, 1.4}), box_at({0, 0, 1.4}, 0.4), nullptr, 0.4, 6.5).box, 1.0, 1e-9);
}

}  // namespace
}  // namespace periplus::vision
