#include "services/motion_controller/walking_pattern.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/core/error.h"
#include "services/motion_controller/trajectory.h"

namespace periplus::motion {
namespace {

// Shares of the single support: the foot travels between these, and is down at `kDown`, so that it lands at rest.
constexpr double kTravelBegin = 0.05, kTravelEnd = 0.90, kDown = 0.95;
// Less than this left of a step, and the preview no longer sees the end coming [s].
constexpr double kHaltNotice = 0.5;
constexpr double kWaistTurn = 0.8;  // at the end, to face as the feet do [s]

double smooth(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}
SolePose on_floor(const Pose2& p) { return {{p.x, p.y, 0}, p.yaw}; }

}  // namespace

void GaitSettings::check() const {
  require(single_support >= 0.2 && single_support <= 10 && double_support >= 0.02 && double_support <= 10,
          ErrorCode::bad_input, "single support must last 0.2 to 10 s, double support 0.02 to 10 s");
  require(first_hold >= 0 && end_double_support >= 0.1 && settle >= preview.preview &&
              first_hold + end_double_support + settle < 60,
          ErrorCode::bad_input,
          "the robot must be given time to stand: end_double_support at least 0.1 s, settle at least the preview");
  require(step_height > 0 && step_height < 0.3, ErrorCode::bad_input, "step height must lie between 0 and 0.3 m");
  require(std::abs(zmp_ahead) < 0.1, ErrorCode::bad_input, "zmp_ahead must lie within the sole, -0.1 to 0.1 m");
}

Eigen::Vector2d WalkingPattern::pressure_point(const GaitSettings& settings, const Pose2& sole) {
  return {sole.x + settings.zmp_ahead * std::cos(sole.yaw), sole.y + settings.zmp_ahead * std::sin(sole.yaw)};
}

WalkingPattern::WalkingPattern(const GaitSettings& settings, const std::array<Pose2, 2>& feet,
                               const Eigen::Vector3d& com, const std::vector<Step>& steps)
    : settings_(settings), control_(com.z(), settings.preview), steps_(steps), feet_(feet) {
  settings_.check();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    require(steps[i].foot == 0 || steps[i].foot == 1, ErrorCode::bad_input, "a step's foot is 0 (left) or 1 (right)");
    require(i == 0 || steps[i].foot != steps[i - 1].foot, ErrorCode::bad_input,
            "step " + std::to_string(i) + " moves the same foot as the one before; left and right must alternate");
  }
  compose_ticks();
  states_.resize(1);
  for (int a = 0; a < 2; ++a) states_[0][static_cast<std::size_t>(a)] = PreviewState::at_rest(com(a));
  run_preview(0);
}

void WalkingPattern::compose_ticks() {
  ticks_.clear();
  landed_.clear();
  now_ = {};
  begin();
  for (std::size_t i = 0; i < steps_.size(); ++i)
    add_step(steps_[i], i == 0 ? settings_.end_double_support : settings_.double_support);
  finish();
}

Eigen::Vector2d WalkingPattern::middle() const {
  return 0.5 * (pressure_point(settings_, feet_[0]) + pressure_point(settings_, feet_[1]));
}

void WalkingPattern::begin() {
  now_.soles = {on_floor(feet_[0]), on_floor(feet_[1])};
  now_.waist_yaw = mean_yaw(feet_[0].yaw, feet_[1].yaw);
  now_.zmp_reference = middle();
  ticks_.assign(1 + static_cast<std::size_t>(std::lround(settings_.first_hold / settings_.preview.period)), now_);
}

void WalkingPattern::shift_weight(const Eigen::Vector2d& to, double duration) {
  const int n = std::max(1, static_cast<int>(std::lround(duration / settings_.preview.period)));
  const Eigen::Vector2d from = now_.zmp_reference;
  now_.support = 2;
  for (int k = 1; k <= n; ++k) {
    now_.zmp_reference = from + static_cast<double>(k) / n * (to - from);
    ticks_.push_back(now_);
  }
}

void WalkingPattern::add_step(const Step& step, double double_support) {
  const int moving = step.foot, standing = 1 - moving;
  shift_weight(pressure_point(settings_, feet_[standing]), double_support);
  const Pose2 from = feet_[moving];
  const double turn = wrap_angle(step.sole.yaw - from.yaw);
  const double waist_from = now_.waist_yaw;
  const double waist_turn =
      wrap_angle(mean_yaw(feet_[standing].yaw, step.sole.yaw) - waist_from);
  const int n = static_cast<int>(std::lround(settings_.single_support / settings_.preview.period));
  now_.support = standing;
  for (int k = 1; k <= n; ++k) {
    const double u = static_cast<double>(k) / n;
    const double way = minimum_jerk((u - kTravelBegin) / (kTravelEnd - kTravelBegin));
    const double rise = std::min(1.0, u / kDown);
    SolePose& sole = now_.soles[static_cast<std::size_t>(moving)];
    sole.position = {from.x + way * (step.sole.x - from.x), from.y + way * (step.sole.y - from.y),
                     settings_.step_height * 64 * std::pow(rise * (1 - rise), 3)};
    sole.yaw = from.yaw + way * turn;
    now_.waist_yaw = waist_from + smooth(u) * waist_turn;
    if (k == n) {
      sole = on_floor(step.sole);
      ++now_.steps_done;
    }
    ticks_.push_back(now_);
  }
  feet_[static_cast<std::size_t>(moving)] = step.sole;
  landed_.push_back(ticks_.size() - 1);
}

void WalkingPattern::finish() {
  shift_weight(middle(), settings_.end_double_support);
  const double from = now_.waist_yaw, turn = wrap_angle(mean_yaw(feet_[0].yaw, feet_[1].yaw) - from);
  const int n = static_cast<int>(std::lround(settings_.settle / settings_.preview.period));
  for (int k = 1; k <= n; ++k) {
    now_.waist_yaw = from + smooth(k * settings_.preview.period / kWaistTurn) * turn;
    ticks_.push_back(now_);
  }
}

// The states up to `from` stay.
void WalkingPattern::run_preview(std::size_t from) {
  std::array<std::vector<double>, 2> reference;
  for (std::size_t a = 0; a < 2; ++a) {
    reference[a].reserve(ticks_.size());
    for (const PatternTick& t : ticks_) reference[a].push_back(t.zmp_reference(static_cast<Eigen::Index>(a)));
  }
  states_.resize(ticks_.size());
  for (std::size_t k = from; k < ticks_.size(); ++k) {
    for (std::size_t a = 0; a < 2; ++a) {
      if (k > from) {
        states_[k][a] = states_[k - 1][a];
        control_.advance(states_[k][a], std::span(reference[a]).subspan(k - 1));
      }
    }
  }
  come_to_rest();
  for (std::size_t k = from; k < ticks_.size(); ++k) {
    for (std::size_t a = 0; a < 2; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      ticks_[k].com(axis) = states_[k][a].com(0);
      ticks_[k].com_speed(axis) = states_[k][a].com(1);
      ticks_[k].zmp(axis) = control_.zmp(states_[k][a]);
    }
  }
}

// The preview control only halves what is left of the way to the middle of the feet every 0.2 s. In the second half of
// the settling that fades out along a minimum jerk, speed and acceleration with it.
void WalkingPattern::come_to_rest() {
  const std::size_t n = ticks_of(0.5 * settings_.settle), begin = ticks_.size() - 1 - n;
  const double duration = static_cast<double>(n) * settings_.preview.period;
  for (std::size_t k = 1; k <= n; ++k) {
    const double u = static_cast<double>(k) / static_cast<double>(n);
    const double left = 1 - minimum_jerk(u), first = -30 * u * u * (1 - u) * (1 - u) / duration,
                 second = -60 * u * (1 - u) * (1 - 2 * u) / (duration * duration);  // and its derivatives
    for (std::size_t a = 0; a < 2; ++a) {
      Eigen::Vector3d& com = states_[begin + k][a].com;
      const double middle = ticks_.back().zmp_reference(static_cast<Eigen::Index>(a)), away = com(0) - middle;
      com = {middle + left * away, left * com(1) + first * away, left * com(2) + 2 * first * com(1) + second * away};
    }
  }
}

std::size_t WalkingPattern::ticks_of(double seconds) const {
  return static_cast<std::size_t>(std::lround(seconds / settings_.preview.period));
}

void WalkingPattern::halt(std::size_t tick, std::size_t further) {
  tick = std::min(tick, ticks_.size() - 1);
  const std::size_t noticed = tick + ticks_of(kHaltNotice);
  std::size_t kept = 0;
  if (tick > ticks_of(settings_.first_hold)) {  // before, the weight has not moved yet: no step is needed
    while (kept < landed_.size() && landed_[kept] < noticed) ++kept;
    const bool under_way = kept < landed_.size() && landed_[kept] - ticks_of(settings_.single_support) <= noticed;
    if (under_way || kept == 0) ++kept;
  }
  kept += further;
  if (kept >= landed_.size()) return;  // ends by itself as soon

  const std::vector<PatternTick> executed(ticks_.begin(), ticks_.begin() + static_cast<std::ptrdiff_t>(tick) + 1);
  for (std::size_t f = 0; f < 2; ++f) {
    const SolePose& sole = executed[0].soles[f];
    feet_[f] = {sole.position.x(), sole.position.y(), sole.yaw};
  }
  steps_.resize(kept);
  compose_ticks();
  // In a double support longer than the closing, the halt may come when that would be over: settle from here.
  ticks_.resize(std::max(ticks_.size(), executed.size() + ticks_of(settings_.settle)), now_);
  std::copy(executed.begin(), executed.end(), ticks_.begin());
  run_preview(tick);
}

}  // namespace periplus::motion
