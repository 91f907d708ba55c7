#include "services/motion_controller/trajectory.h"

#include <gtest/gtest.h>

namespace periplus::motion {
namespace {

TEST(GreatestSpeedRatio, NamesTheFastestJoint) {
  const std::string folder = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/";
  const auto model = robot::RobotModel::load_files(folder + "hrp2like.urdf", folder + "hrp2like.yaml");
  const Eigen::VectorXd before = model->half_sitting();
  const int knee = model->joint_index("LLEG_JOINT3");
  std::vector<Command> commands(3, {2, before});
  commands[1].q(6 + knee) += 0.01;
  std::string joint;
  const double limit = model->joints()[static_cast<std::size_t>(knee)].max_speed;
  EXPECT_NEAR(greatest_speed_ratio(*model, before, commands, 0, 0.005, joint), 0.01 / 0.005 / limit, 1e-12);
  EXPECT_EQ(joint, "LLEG_JOINT3");
  // The base may move as it likes.
  commands[1].q = before;
  commands[1].q(0) += 1;
  EXPECT_EQ(greatest_speed_ratio(*model, before, commands, 0, 0.005, joint), 0);
  // The first command counts against where the robot stands.
  commands[0].q(6 + knee) += 0.02;
  commands[1].q = commands[2].q = commands[0].q;
  EXPECT_NEAR(greatest_speed_ratio(*model, before, commands, 0, 0.005, joint), 0.02 / 0.005 / limit, 1e-12);
  EXPECT_EQ(greatest_speed_ratio(*model, before, commands, 1, 0.005, joint), 0);
}

TEST(MinimumJerk, BeginsAndEndsAtRest) {
  EXPECT_EQ(minimum_jerk(0), 0);
  EXPECT_EQ(minimum_jerk(1), 1);
  EXPECT_EQ(minimum_jerk(-1), 0);
  EXPECT_EQ(minimum_jerk(2), 1);
  EXPECT_DOUBLE_EQ(minimum_jerk(0.5), 0.5);
  EXPECT_LT(minimum_jerk(1e-3), 1.1e-8);  // of third order
}

}  // namespace
}  // namespace periplus::motion
