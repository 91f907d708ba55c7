#include "common/robot/robot_model.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/robot/capsule_distance.h"

namespace periplus::robot {

namespace {

std::string file(const std::string& name) { return read_file(std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/" + name); }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::shared_ptr<const RobotModel> hrp2like() {
  static const auto model = RobotModel::load(file("hrp2like.urdf"), file("hrp2like.yaml"));
  return model;
}

std::string refusal(const std::string& urdf, const std::string& yaml) {
  try {
    RobotModel::load(urdf, yaml);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.what();
  }
  return "accepted";
}

constexpr double kDegree = std::numbers::pi / 180;

}  // namespace

TEST(RobotModel, PublishedFigures) {
  const auto model = hrp2like();
  EXPECT_EQ(model->name(), "hrp2like");
  EXPECT_EQ(model->joints().size(), 30u);
  EXPECT_EQ(model->dof(), 36);
  EXPECT_NEAR(model->mass(), 58.0, 1e-6);
  const Joint& knee = model->joints()[model->joint_index("RLEG_JOINT3")];
  EXPECT_NEAR(knee.lower, -2 * kDegree, 1e-5);
  EXPECT_NEAR(knee.upper, 150 * kDegree, 1e-5);
  EXPECT_DOUBLE_EQ(knee.max_torque, 168);
  EXPECT_NEAR(knee.posture_upper, 126 * kDegree, 1e-9);
  const Joint& hip = model->joints()[model->joint_index("LLEG_JOINT1")];
  EXPECT_NEAR(hip.posture_lower, hip.lower + 5.73 * kDegree, 1e-9);
}

TEST(RobotModel, HalfSittingStandsOnTheFloor) {
  const auto model = hrp2like();
  const Pose2 floor{1.2, -0.7, 2.0};
  Kinematics kinematics(model);
  const Eigen::VectorXd q = model->half_sitting(floor);
  kinematics.set(q);
  EXPECT_NEAR(q[2], 0.648702, 1e-5);  // published height of the waist
  const Pose2 left = compose(inverse(floor), to_pose2(kinematics.X_WS_left()));
  const Pose2 right = compose(inverse(floor), to_pose2(kinematics.X_WS_right()));
  EXPECT_NEAR(kinematics.X_WS_left().translation().z(), 0, 1e-9);
  EXPECT_NEAR(kinematics.X_WS_right().translation().z(), 0, 1e-9);
  EXPECT_NEAR(left.x, 0, 1e-9);
  EXPECT_NEAR(left.y, 0.095, 1e-9);
  EXPECT_NEAR(right.x, 0, 1e-9);
  EXPECT_NEAR(right.y, -0.095, 1e-9);
  EXPECT_NEAR(wrap_angle(left.yaw), 0, 1e-9);
  EXPECT_NEAR(kinematics.center_of_mass().z(), 0.81, 0.01);
  // The centre of mass lies over the soles.
  const Eigen::Vector3d com = to_pose(floor).inverse() * kinematics.center_of_mass();
  EXPECT_NEAR(com.y(), 0, 1e-4);  // the hands are both turned the same way
  EXPECT_GT(com.x(), -0.05);
  EXPECT_LT(com.x(), 0.05);
}

TEST(RobotModel, BodyBoxHoldsHalfSitting) {
  const auto model = hrp2like();
  Kinematics kinematics(model);
  Eigen::Vector3d lower = Eigen::Vector3d::Constant(9), upper = -lower;
  for (std::size_t i = 0; i < model->capsules().size(); ++i) {
    Eigen::Vector3d a, b;
    kinematics.capsule(static_cast<int>(i), a, b);
    lower = lower.cwiseMin(a.cwiseMin(b) - Eigen::Vector3d::Constant(model->capsules()[i].radius));
    upper = upper.cwiseMax(a.cwiseMax(b) + Eigen::Vector3d::Constant(model->capsules()[i].radius));
  }
  lower.z() = std::max(lower.z(), 0.0);  // round soles
  EXPECT_TRUE((model->body_box().lower.array() <= lower.array() + 1e-9).all()) << lower.transpose();
  EXPECT_TRUE((model->body_box().upper.array() >= upper.array() - 1e-9).all()) << upper.transpose();
  // And not much more: the walk needs narrow passages.
  EXPECT_LT((model->body_box().upper - upper).maxCoeff(), 0.06) << upper.transpose();
  EXPECT_LT((lower - model->body_box().lower).maxCoeff(), 0.06) << lower.transpose();
}

TEST(RobotModel, StereoRigAndCameras) {
  const auto model = hrp2like();
  const StereoRig rig = model->stereo_rig();
  EXPECT_NEAR(rig.baseline, 0.144, 1e-12);
  EXPECT_NEAR(rig.camera.vertical_fov(), 25 * kDegree, 1e-9);
  EXPECT_NEAR(model->camera("wide").pinhole.horizontal_fov(), 90 * kDegree, 0.001);
  Kinematics kinematics(model);
  kinematics.set(model->half_sitting());
  const Pose X = kinematics.X_WC("left");
  const Eigen::Vector3d direction = camera_yaw_pitch_roll(X);
  EXPECT_NEAR(direction.x(), 0, 1e-9);
  EXPECT_NEAR(direction.y(), 10 * kDegree, 1e-9);
  EXPECT_NEAR(direction.z(), 0, 1e-9);
  EXPECT_NEAR(X.translation().z(), 0.648702 + 0.35 + 0.30 + 0.045, 1e-5);
  EXPECT_NEAR(X.translation().y(), 0.072, 1e-9);
  EXPECT_NEAR((kinematics.X_WC("right").translation() - X * Eigen::Vector3d(0.144, 0, 0)).norm(), 0, 1e-12);
}

TEST(RobotModel, SelfCollisionPairsLeaveNeighboursOut) {
  const auto model = hrp2like();
  const auto has = [&](const std::string& a, const std::string& b) {
    for (const auto& [i, j] : model->self_collision_pairs()) {
      const std::string &first = model->capsules()[i].name, &second = model->capsules()[j].name;
      if ((first == a && second == b) || (first == b && second == a)) return true;
    }
    return false;
  };
  EXPECT_TRUE(has("Rthigh", "Lthigh"));
  EXPECT_TRUE(has("Rhand", "Rthigh"));
  EXPECT_TRUE(has("Rfoot_i", "Lfoot_o"));
  EXPECT_FALSE(has("Rthigh", "Rshank"));   // neighbours
  EXPECT_FALSE(has("pelvis", "Rthigh"));   // no capsule between them
  EXPECT_FALSE(has("Rfoot_o", "Rfoot_i"));  // one link
  EXPECT_TRUE(has("pelvis", "Rshank"));
}

TEST(RobotModel, UnknownNamesAreAnsweredWithTheNearest) {
  const auto model = hrp2like();
  try {
    model->joint_index("RLEG_JOINT33");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'RLEG_JOINT3'"), std::string::npos) << error.what();
  }
  EXPECT_THROW(model->camera("middle"), Error);
  Kinematics kinematics(model);
  EXPECT_THROW(kinematics.X_WL("HEAD"), Error);
}

TEST(RobotModel, RefusesWhatCannotBeUsed) {
  const std::string urdf = file("hrp2like.urdf"), yaml = file("hrp2like.yaml");
  EXPECT_EQ(refusal(urdf, yaml), "accepted");
  const auto says = [&](const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  says(refusal("<robot name='x'>", yaml), "not XML");
  says(refusal(replaced(urdf, "<child link=\"HEAD_LINK1\"/>", "<child link=\"HEAD_LINK9\"/>"), yaml), "HEAD_LINK9");
  says(refusal(urdf, replaced(yaml, "RLEG_JOINT2:", "RLEG_JIONT2:")), "did you mean 'RLEG_JOINT2'");
  says(refusal(urdf, replaced(yaml, "link: HEAD_LINK1", "link: HEAD")), "there is no link 'HEAD'");
  says(refusal(urdf, replaced(yaml, "half_sitting_deg: 50", "half_sitting_deg: 170")), "outside its URDF limits");
  says(refusal(urdf, replaced(yaml, "half_sitting_deg: 50", "half_sitting_deg: 40")), "not level");
  says(refusal(urdf, replaced(yaml, "base_link: BODY", "base_link: TORSO")), "name that one");
  says(refusal(urdf, replaced(yaml, "radius_m: 0.105", "radius_m: 0.45")), "overlap");
  says(refusal(urdf, replaced(yaml, "feet:", "shoes:")), "foot is missing");
  says(refusal(urdf, replaced(yaml, "view_limits:", "view_limit:")), "view_limit");
}

TEST(RobotModel, MissingStereoCameraIsNamed) {
  const auto model = RobotModel::load(file("hrp2like.urdf"), replaced(file("hrp2like.yaml"), "name: right", "name: rechts"));
  try {
    model->stereo_rig();
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("there is no camera 'right'"), std::string::npos) << error.what();
  }
}

TEST(RobotModel, MissingFileIsNamed) {
  try {
    RobotModel::load_files("/nowhere/robot.urdf", "/nowhere/robot.yaml");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::io);
  }
}

}  // namespace periplus::robot
