// The robot of mode `ideal`: joints go exactly where they are commanded, the standing foot stays where it is, and the base
// follows from the kinematics. Time advances by one tick a command.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "common/geometry/pose.h"
#include "common/robot/robot_model.h"

namespace periplus::simulator {

enum class Support { left = 0, right = 1, both = 2 };  // both: the left foot is the anchor

struct RobotState {
  std::uint64_t tick = 0;
  std::int64_t stamp_ns = 0;              // simulated time
  Eigen::VectorXd positions, velocities;  // [rad], [rad/s], in the model's order
  Pose X_WB = Pose::Identity();           // base link
  Pose X_W_left = Pose::Identity();       // sole frames
  Pose X_W_right = Pose::Identity();
  bool fallen = false;
};

struct IdealRobotOptions {
  std::int64_t tick_ns = 5'000'000;
  double joint_limit_slack = 0.01;        // [rad]
  std::uint64_t fall_at_tick = 0;         // reports a fall from this tick on; 0: never
  std::size_t states_kept = 64;           // for commands that come again
};

class IdealRobot {
 public:
  // Half-sitting at `start`.
  IdealRobot(std::shared_ptr<const robot::RobotModel> model, const Pose2& start, const IdealRobotOptions& options = {});

  const RobotState& state() const { return states_.back(); }
  const robot::RobotModel& model() const { return *model_; }

  // Command number n leads from state n to state n + 1. One that was executed before is answered with the state that
  // followed it. Throws Error(not_finite | bad_size | motion_joint_limit) for one that cannot be executed, Error(bad_input)
  // for one that runs ahead or lies too far back; the state stays as it is.
  const RobotState& command(std::uint64_t tick, Support support, const Eigen::VectorXd& positions);

  // Optical frame of a camera in the present state.
  Pose X_WC(const std::string& camera);

 private:
  void check(const Eigen::VectorXd& positions) const;
  void set_kinematics(const Pose& X_WB, const Eigen::VectorXd& positions);

  std::shared_ptr<const robot::RobotModel> model_;
  robot::Kinematics kinematics_;
  IdealRobotOptions options_;
  std::deque<RobotState> states_;
  bool anchor_is_left_ = true;
  Pose X_W_anchor_ = Pose::Identity();
};

}  // namespace periplus::simulator
