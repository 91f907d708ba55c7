// Inverse kinematics of base and legs: the soles go exactly where they are asked, the centre of mass follows, and the
// waist keeps its attitude as far as the joint limits leave room (stack of tasks of thesis 5.2.4, as weights that
// differ by orders of magnitude). The joints of the upper body stay as given. World frame.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "common/geometry/pose.h"
#include "common/robot/robot_model.h"

namespace periplus::motion {

struct BodyTarget {
  Eigen::Vector3d com{0, 0, 0};                                // [m]
  Eigen::Matrix3d R_waist = Eigen::Matrix3d::Identity();       // attitude of the base link
  Pose X_left = Pose::Identity(), X_right = Pose::Identity();  // sole frames
};

struct IkResult {
  double sole_error = 0;   // greatest of both soles, position [m] and rotation [rad]
  double com_error = 0;    // [m]
  double waist_error = 0;  // [rad]
  int iterations = 0;
  std::vector<int> at_limit;  // joints (in RobotModel::joints()) held at a limit at the end
};

class WholeBodyIk {
 public:
  // Throws Error(bad_input) if a foot hangs on fewer than six joints.
  explicit WholeBodyIk(std::shared_ptr<const robot::RobotModel> model);

  // Newton from `q` (dof() numbers), which becomes the solution. At most `iterations`; ends when all errors are < 1e-9.
  IkResult solve(Eigen::VectorXd& q, const BodyTarget& target, int iterations = 12);

  // Joints (indices into RobotModel::joints()) between the base and the soles; all others are the upper body.
  const std::vector<int>& legs() const { return legs_; }
  const std::vector<int>& upper_body() const { return upper_body_; }
  // What stands where at configuration q.
  BodyTarget measure(const Eigen::VectorXd& q);
  const robot::RobotModel& model() const { return *model_; }

 private:
  std::shared_ptr<const robot::RobotModel> model_;
  robot::Kinematics kinematics_;
  std::vector<int> legs_, upper_body_;
  std::vector<int> columns_;  // of the Jacobians: base, then legs
};

// Rotation vector that turns from to `to` [rad], world axes.
Eigen::Vector3d rotation_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to);

}  // namespace periplus::motion
