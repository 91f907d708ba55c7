#include "services/simulator/ideal_robot.h"

#include <algorithm>
#include <cmath>

#include "common/core/error.h"

namespace periplus::simulator {

IdealRobot::IdealRobot(std::shared_ptr<const robot::RobotModel> model, const Pose2& start, const IdealRobotOptions& options)
    : model_(std::move(model)), kinematics_(model_), options_(options) {
  require(options_.tick_ns > 0 && options_.states_kept > 0, ErrorCode::bad_input, "the robot's tick and its memory must be positive");
  const Eigen::VectorXd q = model_->half_sitting(start);
  kinematics_.set(q);
  RobotState first;
  first.positions = q.tail(q.size() - 6);
  first.velocities = Eigen::VectorXd::Zero(first.positions.size());
  first.X_WB = kinematics_.X_WL(model_->base_link());
  first.X_W_left = X_W_anchor_ = kinematics_.X_WS_left();
  first.X_W_right = kinematics_.X_WS_right();
  states_.push_back(std::move(first));
}

void IdealRobot::check(const Eigen::VectorXd& positions) const {
  const auto& joints = model_->joints();
  require(positions.size() == static_cast<Eigen::Index>(joints.size()), ErrorCode::bad_size,
          "a command needs " + std::to_string(joints.size()) + " joint positions, this one has " + std::to_string(positions.size()));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double p = positions[static_cast<Eigen::Index>(i)];
    require(std::isfinite(p), ErrorCode::not_finite, "the commanded position of joint " + joints[i].name + " is not a finite number");
    require(p >= joints[i].lower - options_.joint_limit_slack && p <= joints[i].upper + options_.joint_limit_slack, ErrorCode::motion_joint_limit,
            "joint " + joints[i].name + " was commanded to " + std::to_string(p) + " rad, beyond its limits " + std::to_string(joints[i].lower) +
                " to " + std::to_string(joints[i].upper));
  }
}

void IdealRobot::set_kinematics(const Pose& X_WB, const Eigen::VectorXd& positions) {
  Eigen::VectorXd q(model_->dof());
  q.head<3>() = X_WB.translation();
  q.segment<3>(3) = yaw_pitch_roll(X_WB.linear());
  q.tail(positions.size()) = positions;
  kinematics_.set(q);
}

const RobotState& IdealRobot::command(std::uint64_t tick, Support support, const Eigen::VectorXd& positions) {
  const RobotState& now = state();
  if (tick < now.tick) {
    const auto found = std::find_if(states_.begin(), states_.end(), [&](const RobotState& s) { return s.tick == tick + 1; });
    require(found != states_.end(), ErrorCode::bad_input,
            "command " + std::to_string(tick) + " lies too far back; ask robot/state and go on from tick " + std::to_string(now.tick));
    return *found;
  }
  require(tick == now.tick, ErrorCode::bad_input,
          "command " + std::to_string(tick) + " runs ahead; the robot is at tick " + std::to_string(now.tick));
  check(positions);

  const bool left = support != Support::right;
  if (left != anchor_is_left_) {
    anchor_is_left_ = left;
    X_W_anchor_ = left ? now.X_W_left : now.X_W_right;
  }
  set_kinematics(Pose::Identity(), positions);
  const Pose X_B_sole = left ? kinematics_.X_WS_left() : kinematics_.X_WS_right();
  RobotState next;
  next.X_WB = X_W_anchor_ * X_B_sole.inverse();
  set_kinematics(next.X_WB, positions);
  next.tick = now.tick + 1;
  next.stamp_ns = static_cast<std::int64_t>(next.tick) * options_.tick_ns;
  next.positions = positions;
  next.velocities = (positions - now.positions) / (static_cast<double>(options_.tick_ns) * 1e-9);
  next.X_W_left = left ? X_W_anchor_ : kinematics_.X_WS_left();
  next.X_W_right = left ? kinematics_.X_WS_right() : X_W_anchor_;
  next.fallen = options_.fall_at_tick > 0 && next.tick >= options_.fall_at_tick;
  states_.push_back(std::move(next));
  if (states_.size() > options_.states_kept) states_.pop_front();
  return state();
}

Pose IdealRobot::X_WC(const std::string& camera) {
  set_kinematics(state().X_WB, state().positions);
  return kinematics_.X_WC(camera);
}

}  // namespace periplus::simulator
