#include "services/posture_generator/static_torques.h"

namespace periplus::posture {

Eigen::VectorXd static_torques(const robot::Kinematics& kinematics) {
  constexpr double kGravity = 9.81;
  const robot::RobotModel& robot = kinematics.model();
  const Pose left = kinematics.X_WS_left(), right = kinematics.X_WS_right();
  const Eigen::Vector2d a = left.translation().head<2>(), along = right.translation().head<2>() - a;
  const Eigen::Vector2d com = kinematics.center_of_mass().head<2>();
  const double share = (com - a).dot(along) / along.squaredNorm();  // of the right foot
  Eigen::Vector3d beside = Eigen::Vector3d::Zero();
  beside.head<2>() = com - a - share * along;
  const double weight = robot.mass() * kGravity;
  Eigen::VectorXd torques = kinematics.gravity();
  const auto lift = [&](const robot::Foot& foot, const Pose& X_WS, double force) {
    const Eigen::Vector3d p_L = foot.X_LS * (X_WS.linear().transpose() * beside);
    torques -= force * kinematics.jacobian(foot.link, p_L).row(2).transpose();
  };
  lift(robot.left_foot(), left, (1 - share) * weight);
  lift(robot.right_foot(), right, share * weight);
  return torques;
}

}  // namespace periplus::posture
