#include "services/posture_generator/static_torques.h"

#include <gtest/gtest.h>

#include <cmath>

namespace periplus::posture {

namespace {
std::shared_ptr<const robot::RobotModel> hrp2like() {
  const std::string folder = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/";
  return robot::RobotModel::load_files(folder + "hrp2like.urdf", folder + "hrp2like.yaml");
}
}  // namespace

TEST(StaticTorques, BalanceTheBase) {
  const auto model = hrp2like();
  robot::Kinematics kinematics(model);
  Eigen::VectorXd q = model->half_sitting({1, 2, 0.7});
  q[6 + model->joint_index("CHEST_JOINT0")] = 0.4;  // arms swing the centre of mass aside
  q[6 + model->joint_index("CHEST_JOINT1")] = 0.5;
  kinematics.set(q);
  const Eigen::VectorXd torques = static_torques(kinematics);
  EXPECT_LT(torques.head<6>().cwiseAbs().maxCoeff(), 1e-6) << torques.head<6>().transpose();
}

TEST(StaticTorques, HalfSittingIsSymmetricAndKneesCarry) {
  const auto model = hrp2like();
  robot::Kinematics kinematics(model);
  kinematics.set(model->half_sitting());
  const Eigen::VectorXd torques = static_torques(kinematics);
  const double right = torques[6 + model->joint_index("RLEG_JOINT3")], left = torques[6 + model->joint_index("LLEG_JOINT3")];
  EXPECT_NEAR(right, left, 0.1);
  // Weight above one knee, about 25 kg, some 12 cm behind it.
  EXPECT_GT(std::abs(right), 20);
  EXPECT_LT(std::abs(right), 60);
}

}  // namespace periplus::posture
