// Executes a trajectory on a robot that answers every command: state n + 1 follows command n. What is lost is sent
// again; a command that was executed already is answered again, never executed twice.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>

#include "common/geometry/pose.h"
#include "common/robot/robot_model.h"
#include "services/motion_controller/trajectory.h"

namespace periplus::motion {

// The robot as it reports itself.
struct RobotReport {
  std::uint64_t tick = 0;
  Eigen::VectorXd joints;  // measured [rad]
  Pose X_base = Pose::Identity();
  Pose X_left = Pose::Identity(), X_right = Pose::Identity();  // sole frames
  bool fallen = false;

  // x y z yaw pitch roll of the base, then the joints.
  Eigen::VectorXd configuration() const;
};

// The way to the robot.
class RobotLink {
 public:
  virtual ~RobotLink() = default;
  virtual void send(std::uint64_t tick, int support, const Eigen::VectorXd& joints) = 0;
  // The newest report whose tick is at least `tick`; nothing if none came within `resend_after`.
  virtual std::optional<RobotReport> wait(std::uint64_t tick, double resend_after) = 0;
};

struct LockstepSettings {
  double resend_after = 0.25;       // [s]
  double silent_after = 5.0;        // [s]
  double tracking_tolerance = 0.2;  // of a measured joint from its command [rad]
  std::size_t progress_every = 20;  // commands

  void check() const;  // throws Error(bad_input)
};

struct Execution {
  RobotReport report;  // the last one
  std::uint64_t commands = 0;
  bool halted = false;  // cut short, and now standing
};

// `halt` is asked before every command; once true the trajectory is cut short and its end executed.
// Throws Error(motion_robot_silent | motion_robot_fault): no answer, fallen, a joint that does not follow (named), or
// another controller's commands.
Execution execute(Trajectory& trajectory, const RobotReport& start, RobotLink& link, const robot::RobotModel& model,
                  const LockstepSettings& settings, const std::function<bool()>& halt,
                  const std::function<void(std::size_t executed)>& progress);

}  // namespace periplus::motion
