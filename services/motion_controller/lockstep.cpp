#include "services/motion_controller/lockstep.h"

#include <cmath>
#include <cstdio>
#include <string>

#include "common/core/error.h"

namespace periplus::motion {

Eigen::VectorXd RobotReport::configuration() const {
  Eigen::VectorXd q(6 + joints.size());
  q << X_base.translation(), yaw_pitch_roll(X_base.linear()), joints;
  return q;
}

void LockstepSettings::check() const {
  require(resend_after > 0 && silent_after >= resend_after, ErrorCode::bad_input,
          "silent_after must be at least resend_after, both positive");
  require(tracking_tolerance > 0 && progress_every > 0, ErrorCode::bad_input,
          "tracking tolerance and progress interval must be positive");
}

namespace {

RobotReport ask(RobotLink& link, std::uint64_t tick, int support, const Eigen::VectorXd& joints,
                const LockstepSettings& s) {
  const int attempts = static_cast<int>(std::ceil(s.silent_after / s.resend_after));
  for (int attempt = 0; attempt < attempts; ++attempt) {
    link.send(tick, support, joints);
    if (std::optional<RobotReport> report = link.wait(tick + 1, s.resend_after)) return *report;
  }
  char text[160];
  std::snprintf(text, sizeof text,
                "the robot has not answered command %llu for %.1f s; is its driver or the simulator running?",
                static_cast<unsigned long long>(tick), s.silent_after);
  throw_error(ErrorCode::motion_robot_silent, text);
}

void check_report(const RobotReport& report, std::uint64_t expected, const Eigen::VectorXd& joints,
                  const robot::RobotModel& model, const LockstepSettings& s) {
  require(!report.fallen, ErrorCode::motion_robot_fault, "the robot has fallen; set it upright and start it anew");
  require(report.tick == expected, ErrorCode::motion_robot_fault,
          "the robot is at tick " + std::to_string(report.tick) + " instead of " + std::to_string(expected) +
              "; is another motion controller commanding it?");
  require(report.joints.size() == joints.size() && report.joints.allFinite(), ErrorCode::motion_robot_fault,
          "the robot reports joints that do not fit its model; use the same robot YAML for both");
  Eigen::Index worst = 0;
  const double off = (report.joints - joints).cwiseAbs().maxCoeff(&worst);
  if (off <= s.tracking_tolerance) return;
  char text[160];
  std::snprintf(text, sizeof text, "joint %s does not follow: %.2f rad from its command",
                model.joints()[static_cast<std::size_t>(worst)].name.c_str(), off);
  throw_error(ErrorCode::motion_robot_fault, text);
}

}  // namespace

Execution execute(Trajectory& trajectory, const RobotReport& start, RobotLink& link, const robot::RobotModel& model,
                  const LockstepSettings& settings, const std::function<bool()>& halt,
                  const std::function<void(std::size_t)>& progress) {
  Execution done;
  done.report = start;
  for (std::size_t executed = 0; executed < trajectory.commands().size();) {
    if (!done.halted && halt()) {
      trajectory.halt(executed);
      done.halted = true;
      continue;
    }
    const Command& command = trajectory.commands()[executed];
    const Eigen::VectorXd joints = command.q.tail(command.q.size() - 6);
    const std::uint64_t tick = done.report.tick;
    done.report = ask(link, tick, command.support, joints, settings);
    check_report(done.report, tick + 1, joints, model, settings);
    ++executed;
    ++done.commands;
    if (executed % settings.progress_every == 0) progress(executed);
  }
  return done;
}

}  // namespace periplus::motion
