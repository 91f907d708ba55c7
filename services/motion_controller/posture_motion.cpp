#include "services/motion_controller/posture_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "common/core/error.h"

namespace periplus::motion {
namespace {

constexpr double kLimitSlack = 1e-6;  // a joint that stands at its limit up to rounding [rad]
constexpr int kStretches = 4;         // attempts to slow down until all joints keep their speeds

void check_joints(const robot::RobotModel& model, Eigen::VectorXd& q, const char* which) {
  require(q.size() == model.dof(), ErrorCode::bad_size,
          std::string(which) + " has " + std::to_string(q.size()) + " numbers; this robot has " +
              std::to_string(model.dof()));
  require(q.allFinite(), ErrorCode::not_finite, std::string(which) + " holds a number that is not finite");
  for (std::size_t j = 0; j < model.joints().size(); ++j) {
    const robot::Joint& joint = model.joints()[j];
    double& value = q(static_cast<Eigen::Index>(6 + j));
    if (value < joint.lower - kLimitSlack || value > joint.upper + kLimitSlack) {
      char numbers[96];
      std::snprintf(numbers, sizeof numbers, " stands at %.4f rad, limits are %.4f to %.4f", value, joint.lower,
                    joint.upper);
      throw_error(ErrorCode::motion_joint_limit, std::string(which) + ": joint " + joint.name + numbers);
    }
    value = std::clamp(value, joint.lower, joint.upper);
  }
}

}  // namespace

void PostureSettings::check() const {
  require(least_duration > 0 && com_speed > 0 && waist_speed > 0 && joint_speed > 0 && halt_duration > 0,
          ErrorCode::bad_input, "durations and speeds of posture moves must be positive");
  require(foot_tolerance > 0 && foot_tolerance_rad > 0, ErrorCode::bad_input, "foot tolerances must be positive");
}

void require_solved(const robot::RobotModel& model, const IkResult& result, const MotionLimits& limits) {
  if (result.sole_error <= limits.sole_tolerance && result.com_error <= limits.com_tolerance) return;
  std::string joints;
  for (const int j : result.at_limit)
    joints += (joints.empty() ? "" : ", ") + model.joints()[static_cast<std::size_t>(j)].name;
  char numbers[128];
  std::snprintf(numbers, sizeof numbers, " (a sole would move by %.1e, the centre of mass by %.1e m)",
                result.sole_error, result.com_error);
  throw_error(ErrorCode::motion_joint_limit,
              (joints.empty() ? std::string("the legs do not reach that far") : "limit of joint " + joints) + numbers +
                  "; choose a posture or steps that the legs can follow");
}

PostureMotion::PostureMotion(std::shared_ptr<const robot::RobotModel> model, const Eigen::VectorXd& start,
                             const Eigen::VectorXd& goal, const PostureSettings& settings, const MotionLimits& limits)
    : ik_(std::move(model)), start_(start), goal_(goal), settings_(settings), limits_(limits) {
  settings_.check();
  check_joints(ik_.model(), start_, "the present configuration");
  check_joints(ik_.model(), goal_, "the wanted configuration");
  from_ = ik_.measure(start_);
  for (const Pose* X : {&from_.X_left, &from_.X_right}) {
    require(std::abs(X->translation().z()) < settings_.foot_tolerance &&
                X->linear()(2, 2) > std::cos(settings_.foot_tolerance_rad),
            ErrorCode::motion_robot_fault,
            "a sole does not stand flat on the floor; bring the robot to a standing posture first");
  }
  // The goal as seen from the feet: turned and moved over the floor so that its feet stand where these do.
  to_ = ik_.measure(goal_);
  const auto between = [](const BodyTarget& t) {
    return middle(to_pose2(t.X_left), to_pose2(t.X_right));
  };
  const Pose X_from_goal = to_pose(compose(between(from_), inverse(between(to_))));
  to_.com = X_from_goal * to_.com;
  to_.R_waist = X_from_goal.linear() * to_.R_waist;
  for (const auto& [have, want] : {std::pair{&from_.X_left, &to_.X_left}, std::pair{&from_.X_right, &to_.X_right}}) {
    const Pose wanted = X_from_goal * *want;
    const double away = (wanted.translation() - have->translation()).norm(), turned = angle_between(wanted, *have);
    if (away > settings_.foot_tolerance || turned > settings_.foot_tolerance_rad) {
      char numbers[96];
      std::snprintf(numbers, sizeof numbers, "%.3f m and %.1f degrees", away, turned * 57.29578);
      throw_error(ErrorCode::bad_input,
                  std::string("the feet of the wanted posture stand otherwise than the robot's, by ") + numbers +
                      "; walk there first");
    }
    *want = *have;
  }
  const Pose base =
      X_from_goal * make_pose(goal_.head<3>(), rotation_from_yaw_pitch_roll(goal_(3), goal_(4), goal_(5)));
  const Eigen::Vector3d angles = yaw_pitch_roll(base.linear());
  goal_.head<3>() = base.translation();
  goal_.segment<3>(3) = angles;
  // The yaw that is nearest to the present one, so that no full turn lies between.
  goal_(3) = start_(3) + wrap_angle(angles(0) - start_(3));

  const auto joints = static_cast<Eigen::Index>(ik_.model().joints().size());
  duration_ = std::max({settings_.least_duration, (to_.com - from_.com).norm() / settings_.com_speed,
                        rotation_between(from_.R_waist, to_.R_waist).norm() / settings_.waist_speed,
                        (goal_ - start_).tail(joints).cwiseAbs().maxCoeff() / settings_.joint_speed});
  for (int attempt = 0;; ++attempt) {
    const auto n = static_cast<std::size_t>(std::max(1.0, std::ceil(duration_ / limits_.period)));
    commands_.clear();
    share_.clear();
    for (std::size_t k = 1; k <= n; ++k) {
      share_.push_back(minimum_jerk(static_cast<double>(k) / static_cast<double>(n)));
      commands_.push_back(at(share_.back(), commands_.empty() ? start_ : commands_.back().q));
    }
    std::string joint;
    const double ratio =
        greatest_speed_ratio(ik_.model(), start_, commands_, 0, limits_.period, joint) / limits_.speed_share;
    if (ratio <= 1) return;
    require(attempt < kStretches, ErrorCode::motion_joint_limit,
            "joint " + joint + " would have to turn faster than it can");
    duration_ *= 1.02 * ratio;
  }
}

Command PostureMotion::at(double share, const Eigen::VectorXd& near) {
  Command command;
  command.q = near;
  for (const int j : ik_.upper_body()) command.q(6 + j) = start_(6 + j) + share * (goal_(6 + j) - start_(6 + j));
  BodyTarget target = from_;
  target.com = from_.com + share * (to_.com - from_.com);
  const Eigen::Vector3d turn = rotation_between(from_.R_waist, to_.R_waist);
  if (turn.norm() > 0) target.R_waist = Eigen::AngleAxisd(share * turn.norm(), turn.normalized()) * from_.R_waist;
  const IkResult result = ik_.solve(command.q, target);
  require_solved(ik_.model(), result, limits_);
  return command;
}

double PostureMotion::fraction(std::size_t executed) const {
  return executed == 0 || share_.empty() ? 0 : share_[std::min(executed, share_.size()) - 1];
}

std::string PostureMotion::describe(std::size_t executed) const {
  char text[64];
  std::snprintf(text, sizeof text, "posture, %.0f %%", 100 * fraction(executed));
  return text;
}

void PostureMotion::halt(std::size_t executed) {
  if (executed >= commands_.size()) return;
  const double here = executed == 0 ? 0 : share_[executed - 1];
  const double before = executed < 2 ? 0 : share_[executed - 2];
  const double speed = here - before;  // a command
  commands_.resize(executed);
  share_.resize(executed);
  if (speed <= 0) return;
  // Constant deceleration; never beyond the goal.
  const double n =
      std::min(settings_.halt_duration / limits_.period, std::max(1.0, std::floor(2 * (1 - here) / speed)));
  for (double k = 1; k <= n; ++k) {
    const double share = std::min(1.0, here + speed * (k - 0.5 * k * k / n));
    commands_.push_back(at(share, commands_.back().q));
    share_.push_back(share);
  }
  // The last one came at half a period's deceleration; after the same once more the robot rests.
  commands_.push_back(commands_.back());
  share_.push_back(share_.back());
}

Eigen::VectorXd standing_configuration(WholeBodyIk& ik, const Eigen::VectorXd& q, const Eigen::Vector2d& com_xy,
                                       double com_height, double waist_yaw, const MotionLimits& limits) {
  BodyTarget target = ik.measure(q);
  target.com << com_xy, com_height;
  target.R_waist = rotation_from_yaw_pitch_roll(waist_yaw, 0, 0);
  // Legs of the half-sitting model are a good start from wherever the robot comes.
  Eigen::VectorXd standing = ik.model().half_sitting({com_xy.x(), com_xy.y(), waist_yaw});
  const IkResult result = ik.solve(standing, target, 50);
  require_solved(ik.model(), result, limits);
  return standing;
}

}  // namespace periplus::motion
