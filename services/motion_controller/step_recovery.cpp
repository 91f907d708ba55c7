#include "services/motion_controller/step_recovery.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/core/error.h"
#include "services/motion_controller/posture_motion.h"

namespace periplus::motion {
namespace {

constexpr double kLifted = 1e-4;     // above the floor: in the air [m]
constexpr double kSamePlace = 1e-3;  // a foot that stands where a step put it [m], [rad]
constexpr double kComSpeed = 0.06;   // mean [m/s]
constexpr double kSwingTime = 0.7, kLowerTime = 0.5, kShiftTime = 0.8;  // least durations [s]

bool stands_at(const Pose& X, const Pose2& p) {
  const Pose2 now = to_pose2(X);
  return std::hypot(now.x - p.x, now.y - p.y) < kSamePlace && std::abs(wrap_angle(now.yaw - p.yaw)) < kSamePlace;
}

}  // namespace

WalkPlace find_place(const std::vector<Step>& steps, const Pose& X_left, const Pose& X_right) {
  const std::array<const Pose*, 2> X{&X_left, &X_right};
  const std::array<bool, 2> lifted{X_left.translation().z() > kLifted, X_right.translation().z() > kLifted};
  require(!(lifted[0] && lifted[1]), ErrorCode::motion_robot_fault,
          "both feet are in the air; set the robot on its feet");
  if (lifted[0] || lifted[1]) {
    const int foot = lifted[0] ? 0 : 1;
    const Pose& standing = *X[static_cast<std::size_t>(1 - foot)];
    // The last step of this foot that begins while the other one stands where it does.
    for (std::size_t i = steps.size(); i-- > 0;)
      if (steps[i].foot == foot && (i == 0 || stands_at(standing, steps[i - 1].sole))) return {i + 1, foot};
    throw_error(ErrorCode::motion_robot_fault,
                "a foot is in the air that none of the steps moves; set the robot on its feet");
  }
  for (std::size_t done = steps.size(); done > 1; --done) {
    const Step &last = steps[done - 1], &before = steps[done - 2];
    if (last.foot == before.foot || last.foot < 0 || last.foot > 1 || before.foot < 0 || before.foot > 1) continue;
    if (stands_at(*X[static_cast<std::size_t>(last.foot)], last.sole) &&
        stands_at(*X[static_cast<std::size_t>(before.foot)], before.sole))
      return {done, std::nullopt};
  }
  return {};
}

LandFoot::LandFoot(std::shared_ptr<const robot::RobotModel> model, const Eigen::VectorXd& start, int foot,
                   const Pose2& landing, const GaitSettings& gait, const MotionLimits& limits)
    : ik_(std::move(model)), limits_(limits), foot_(foot), q_(start) {
  require(foot == 0 || foot == 1, ErrorCode::bad_input, "a foot is 0 (left) or 1 (right)");
  now_ = ik_.measure(q_);
  const Pose2 standing = to_pose2(foot == 0 ? now_.X_right : now_.X_left);
  require(std::hypot(landing.x - standing.x, landing.y - standing.y) < 0.6, ErrorCode::bad_input,
          "the landing is out of the leg's reach");
  const auto sole = [this](BodyTarget& t) -> Pose& { return foot_ == 0 ? t.X_left : t.X_right; };

  BodyTarget to = now_;
  to.com.head<2>() = WalkingPattern::pressure_point(gait, standing);
  // The other leg reaches as far as a step goes only from a little lower.
  to.com.z() = std::min(to.com.z(), ik_.measure(ik_.model().half_sitting()).com.z() - 0.02);
  move(to, std::max(kShiftTime, (to.com - now_.com).norm() / kComSpeed));

  to = now_;
  const double travel_height = std::max(gait.step_height, sole(to).translation().z());
  sole(to).translation().z() = travel_height;
  move(to, kLowerTime);
  to = now_;
  sole(to) = to_pose(landing, travel_height);
  move(to, kSwingTime);
  to = now_;
  sole(to) = to_pose(landing);
  move(to, kLowerTime);
}

void LandFoot::move(const BodyTarget& to, double duration) {
  const auto between = [](const Pose& a, const Pose& b, double s) {
    const Eigen::Vector3d turn = rotation_between(a.linear(), b.linear());
    Eigen::Matrix3d R = a.linear();
    if (turn.norm() > 0) R = Eigen::AngleAxisd(s * turn.norm(), turn.normalized()).toRotationMatrix() * R;
    return make_pose(a.translation() + s * (b.translation() - a.translation()), R);
  };
  const BodyTarget from = now_;
  const Eigen::VectorXd q = q_;
  const std::size_t begun = commands_.size();
  for (int attempt = 0;; ++attempt) {
    const int n = std::max(1, static_cast<int>(std::ceil(duration / limits_.period)));
    commands_.resize(begun);
    q_ = q;
    for (int k = 1; k <= n; ++k) {
      const double s = minimum_jerk(static_cast<double>(k) / n);
      now_.com = from.com + s * (to.com - from.com);
      now_.X_left = between(from.X_left, to.X_left, s);
      now_.X_right = between(from.X_right, to.X_right, s);
      require_solved(ik_.model(), ik_.solve(q_, now_), limits_);
      commands_.push_back({1 - foot_, q_});
    }
    std::string joint;
    const double ratio =
        greatest_speed_ratio(ik_.model(), q, commands_, begun, limits_.period, joint) / limits_.speed_share;
    if (ratio <= 1) return;
    require(attempt < 3, ErrorCode::motion_joint_limit, "joint " + joint + " would have to turn faster than it can");
    duration *= 1.05 * ratio;
  }
}

double LandFoot::fraction(std::size_t) const { return 0; }

std::string LandFoot::describe(std::size_t) const { return "putting a foot down"; }

}  // namespace periplus::motion
