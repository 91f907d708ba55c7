#include "services/vision_server/camera_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "common/core/error.h"

namespace periplus::vision {
namespace {

std::shared_ptr<const robot::RobotModel> robot_model() {
  const std::string folder = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/";
  return robot::RobotModel::load_files(folder + "hrp2like.urdf", folder + "hrp2like.yaml");
}

JointPositions half_sitting(const robot::RobotModel& model) {
  JointPositions joints;
  for (const robot::Joint& j : model.joints()) joints.emplace_back(j.name, j.half_sitting);
  return joints;
}

TEST(CameraPose, MovesWithTheBase) {
  const auto model = robot_model();
  const JointPositions joints = half_sitting(*model);
  Pose X_WB = Pose::Identity();
  X_WB.translation().z() = 0.7;
  const Pose at_origin = left_eye_pose(model, joints, X_WB);
  EXPECT_GT(at_origin.translation().z(), 1.0);
  const Pose move = make_pose({1, -2, 0.1}, rotation_from_yaw_pitch_roll(2.5, 0.1, -0.2));
  const Pose moved = left_eye_pose(model, joints, move * X_WB);
  EXPECT_TRUE(moved.isApprox(move * at_origin, 1e-9));
}

TEST(CameraPose, FollowsTheJointsByNameInAnyOrder) {
  const auto model = robot_model();
  JointPositions joints = half_sitting(*model);
  const Pose before = left_eye_pose(model, joints, Pose::Identity());
  std::reverse(joints.begin(), joints.end());
  joints.emplace_back("a joint of another robot", 3.0);
  EXPECT_TRUE(left_eye_pose(model, joints, Pose::Identity()).isApprox(before, 1e-12));
  for (auto& [name, position] : joints) position += 0.05;
  EXPECT_FALSE(left_eye_pose(model, joints, Pose::Identity()).isApprox(before, 1e-3));
}

TEST(CameraPose, AMissingJointIsNamed) {
  const auto model = robot_model();
  JointPositions joints = half_sitting(*model);
  const std::string name = joints.back().first;
  joints.pop_back();
  try {
    left_eye_pose(model, joints, Pose::Identity());
    FAIL() << "a pose without all joints";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::vision_images_missing);
    EXPECT_NE(std::string(e.what()).find(name), std::string::npos);
  }
}

}  // namespace
}  // namespace periplus::vision
