// From one posture to another with both feet standing (thesis 5.2.1, 5.2.4): centre of mass on a straight line, waist
// on the shortest turn, chest, head and arms in joint space, all by one minimum-jerk course; so the robot is statically
// stable throughout if it is so at both ends.
#pragma once

#include <memory>

#include "services/motion_controller/trajectory.h"
#include "services/motion_controller/whole_body_ik.h"

namespace periplus::motion {

struct PostureSettings {
  double least_duration = 1.5;  // [s]
  double com_speed = 0.12;      // mean [m/s]
  double waist_speed = 0.4;     // mean [rad/s]
  double joint_speed = 0.5;     // mean [rad/s]
  double halt_duration = 0.5;   // to come to rest when cut short [s]
  // How far the feet of a wanted posture may differ from where the feet stand: after a walk they are there.
  double foot_tolerance = 0.01;  // [m]
  double foot_tolerance_rad = 0.035;

  void check() const;  // throws Error(bad_input)
};

class PostureMotion : public Trajectory {
 public:
  // From `start` to `goal` (dof() numbers each; the goal's base pose is a hint, the feet at `start` decide).
  // Throws Error(bad_input) if the goal's feet stand otherwise or a joint lies beyond its limits,
  // Error(motion_joint_limit) with the joint's name if the way leads beyond them, Error(motion_robot_fault) if the
  // soles do not stand on the floor.
  PostureMotion(std::shared_ptr<const robot::RobotModel> model, const Eigen::VectorXd& start,
                const Eigen::VectorXd& goal, const PostureSettings& settings = {}, const MotionLimits& limits = {});

  double fraction(std::size_t executed) const override;
  std::string describe(std::size_t executed) const override;
  void halt(std::size_t executed) override;
  double duration() const { return duration_; }  // [s]

 private:
  Command at(double share, const Eigen::VectorXd& near);

  WholeBodyIk ik_;
  Eigen::VectorXd start_, goal_;
  BodyTarget from_, to_;
  PostureSettings settings_;
  MotionLimits limits_;
  double duration_ = 0;
  std::vector<double> share_;  // of the way at each command
};

// Half-sitting upper body over feet that stand as at q: the stance in which a walk begins and ends. `com_height` [m]
// of the centre of mass, which stands over `com_xy`; the waist faces `waist_yaw`. Starts the search from q.
// Throws Error(motion_joint_limit) if the legs do not reach.
Eigen::VectorXd standing_configuration(WholeBodyIk& ik, const Eigen::VectorXd& q, const Eigen::Vector2d& com_xy,
                                       double com_height, double waist_yaw, const MotionLimits& limits);

// Throws Error(motion_joint_limit) that names the joint, unless the solution is good.
void require_solved(const robot::RobotModel& model, const IkResult& result, const MotionLimits& limits);

}  // namespace periplus::motion
