#include "services/motion_controller/walk_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/core/error.h"

namespace periplus::motion {
namespace {

// Near enough to the half-sitting stance to begin at once; in x and y the preview takes up the difference.
constexpr double kSameCom = 1e-3, kSameHeight = 1e-5, kSameAngle = 1e-5;
constexpr int kSlowdowns = 3;
// Of a joint's greatest speed, in the end of a halted walk: a few milliradians of lag are better than further steps.
constexpr double kHaltSpeed = 1.1;
// A step longer than any leg's reach is a mistake of the caller's, better named here than as a joint's limit [m].
constexpr double kLongestStep = 0.6;

Pose level(const SolePose& sole) { return make_pose(sole.position, rotation_from_yaw_pitch_roll(sole.yaw, 0, 0)); }

}  // namespace

WalkMotion::WalkMotion(std::shared_ptr<const robot::RobotModel> model, const Eigen::VectorXd& start,
                       const std::vector<Step>& steps, const GaitSettings& gait, const PostureSettings& posture,
                       const MotionLimits& limits)
    : ik_(model), limits_(limits), steps_(steps.size()), start_(start) {
  require(start.size() == model->dof() && start.allFinite(), ErrorCode::bad_size,
          "the present configuration does not fit the robot");
  const BodyTarget now = ik_.measure(start_);
  std::array<Pose2, 2> feet{to_pose2(now.X_left), to_pose2(now.X_right)};
  std::array<Pose2, 2> walked = feet;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    require(steps[i].foot == 0 || steps[i].foot == 1, ErrorCode::bad_input, "a step's foot is 0 (left) or 1 (right)");
    const auto moving = static_cast<std::size_t>(steps[i].foot);
    const Pose2& standing = walked[1 - moving];
    require(std::hypot(steps[i].sole.x - standing.x, steps[i].sole.y - standing.y) < kLongestStep, ErrorCode::bad_input,
            "step " + std::to_string(i) +
                " lands out of reach of the standing foot; plan the steps from where the feet stand");
    walked[moving] = steps[i].sole;
  }

  const Eigen::VectorXd half_sitting = model->half_sitting();
  height_ = ik_.measure(half_sitting).com.z();
  const Eigen::Vector2d middle =
      0.5 * (WalkingPattern::pressure_point(gait, feet[0]) + WalkingPattern::pressure_point(gait, feet[1]));
  const double yaw = mean_yaw(feet[0].yaw, feet[1].yaw);
  double upper_body_off = 0;
  for (const int j : ik_.upper_body())
    upper_body_off = std::max(upper_body_off, std::abs(start_(6 + j) - half_sitting(6 + j)));
  stance_ = start_;
  if ((now.com.head<2>() - middle).norm() > kSameCom || std::abs(now.com.z() - height_) > kSameHeight ||
      upper_body_off > kSameAngle ||
      rotation_between(now.R_waist, rotation_from_yaw_pitch_roll(yaw, 0, 0)).norm() > kSameAngle) {
    lead_ = std::make_unique<PostureMotion>(
        model, start_, standing_configuration(ik_, start_, middle, height_, yaw, limits_), posture, limits_);
    commands_ = lead_->commands();
    stance_ = commands_.back().q;
  }
  if (steps.empty()) return;

  GaitSettings pace = gait;
  pace.preview.period = limits_.period;
  for (int attempt = 0;; ++attempt) {
    pattern_ = std::make_unique<WalkingPattern>(pace, feet, ik_.measure(stance_).com, steps);
    follow_pattern(lead());
    std::string joint;
    const double ratio =
        greatest_speed_ratio(*model, start_, commands_, lead(), limits_.period, joint) / limits_.speed_share;
    if (ratio <= 1) return;
    require(attempt < kSlowdowns, ErrorCode::motion_joint_limit,
            "joint " + joint + " would have to turn faster than it can");
    pace.single_support *= 1.05 * ratio;
    pace.double_support *= 1.05 * ratio;
  }
}

void WalkMotion::follow_pattern(std::size_t from_command) {
  const std::vector<PatternTick>& ticks = pattern_->ticks();
  commands_.resize(from_command);
  for (std::size_t k = 1 + from_command - lead(); k < ticks.size(); ++k) {
    const PatternTick& tick = ticks[k];
    Command command;
    command.support = tick.support;
    const std::size_t done = commands_.size();
    command.q = done == 0 ? stance_ : commands_.back().q;
    // Joint speeds change slowly: two commands before tell where the legs will be, and one Newton step remains.
    if (done >= lead() + 2) command.q += commands_[done - 1].q - commands_[done - 2].q;
    for (const int j : ik_.legs()) {
      const robot::Joint& joint = ik_.model().joints()[static_cast<std::size_t>(j)];
      command.q(6 + j) = std::clamp(command.q(6 + j), joint.lower, joint.upper);
    }
    BodyTarget target;
    target.com << tick.com, height_;
    target.R_waist = rotation_from_yaw_pitch_roll(tick.waist_yaw, 0, 0);
    target.X_left = level(tick.soles[0]);
    target.X_right = level(tick.soles[1]);
    require_solved(ik_.model(), ik_.solve(command.q, target), limits_);
    commands_.push_back(std::move(command));
  }
}

double WalkMotion::fraction(std::size_t executed) const {
  if (executed >= commands_.size()) return 1;
  if (!pattern_) return lead_ ? lead_->fraction(executed) : 1;
  if (executed <= lead() || steps_ == 0) return 0;
  return static_cast<double>(pattern_->ticks()[executed - lead()].steps_done) / static_cast<double>(steps_);
}

std::string WalkMotion::describe(std::size_t executed) const {
  if (!pattern_ || executed <= lead()) return "to half-sitting";
  char text[64];
  std::snprintf(text, sizeof text, "step %d of %zu",
                pattern_->ticks()[std::min(executed - lead(), pattern_->ticks().size() - 1)].steps_done, steps_);
  return text;
}

void WalkMotion::halt(std::size_t executed) {
  if (executed >= commands_.size()) return;
  if (!pattern_ || executed < lead()) {
    lead_->halt(executed);
    commands_ = lead_->commands();
    pattern_.reset();
    return;
  }
  // Where a leg would not reach or would be too slow, were the step under way the last, the walk goes on to the next one:
  // at the latest it ends as it was planned.
  const WalkingPattern planned = *pattern_;
  for (std::size_t further = 0; further < steps_; ++further) {
    *pattern_ = planned;
    pattern_->halt(executed - lead(), further);
    if (can_follow_pattern(executed)) return;
  }
  *pattern_ = planned;
  follow_pattern(executed);
}

bool WalkMotion::can_follow_pattern(std::size_t from_command) {
  try {
    follow_pattern(from_command);
  } catch (const Error& e) {
    if (e.code() == ErrorCode::motion_joint_limit) return false;
    throw;
  }
  std::string joint;
  return greatest_speed_ratio(ik_.model(), start_, commands_, from_command, limits_.period, joint) <= kHaltSpeed;
}

}  // namespace periplus::motion
