#include "services/walk_planner/footstep_planner.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "common/core/error.h"

namespace periplus::walk {
namespace {

constexpr double kSame = 1e-4;         // feet that stand there already [m], [rad]
constexpr double kSlack = 1e-9;        // limits are met up to rounding
constexpr int kDeepestTransition = 9;  // steps between two arrangements of the feet at one place
constexpr double kWaypointDistance = 0.01, kWaypointTurn = 0.02;  // along the path [m], [rad]

bool same(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y) < kSame && std::abs(wrap_angle(a.yaw - b.yaw)) < kSame;
}
bool same(const Feet& a, const Feet& b) { return same(a.left, b.left) && same(a.right, b.right); }

// A place in the standing foot's outward frame, back in the world.
Pose2 from_outward(const Pose2& standing, const Pose2& place, bool moving_left) {
  const double side = moving_left ? 1 : -1;
  return compose(standing, {place.x, side * place.y, side * place.yaw});
}

// The landing within the limits that is nearest to where the foot wants to go.
Pose2 clipped(const StepSettings& s, const Pose2& standing, const Pose2& wanted, bool moving_left) {
  Pose2 p = outward(standing, wanted, moving_left);
  p.x = std::clamp(p.x, s.step.x_min, s.step.x_max);
  p.yaw = std::clamp(p.yaw, -s.step.yaw_in, s.step.yaw_out);
  p.y = std::clamp(p.y, s.step.y_min, s.step.y_max);
  // A foot that is turned sees the other one nearer when it stands ahead or behind: step out until it is clear.
  while (p.y < s.step.y_max && -std::sin(p.yaw) * p.x + std::cos(p.yaw) * p.y < s.clearance)
    p.y = std::min(p.y + 0.005, s.step.y_max);
  return from_outward(standing, p, moving_left);
}

class Transition {
 public:
  Transition(const Feet& goal, bool posture, double half_width, const StepSettings& s)
      : goal_(goal), posture_(posture), half_width_(half_width), s_(s) {}

  // The shortest alternating sequence found; `first`: which foot must begin. Nothing if there is none.
  std::optional<std::vector<Footstep>> find(const Feet& start, std::optional<bool> first_left) {
    if (same(start, goal_)) return std::vector<Footstep>{};
    for (int depth = 1; depth <= kDeepestTransition; ++depth) {
      for (const bool left : {true, false}) {
        if (first_left && *first_left != left) continue;
        steps_.clear();
        if (search(start, left, depth)) return steps_;
      }
    }
    return std::nullopt;
  }

 private:
  bool search(const Feet& feet, bool left, int depth) {
    if (depth == 0) return false;
    const Pose2& standing = left ? feet.right : feet.left;
    const Pose2& wanted = left ? goal_.left : goal_.right;
    // Beside the standing foot: squares the feet up when the goal is out of reach.
    const Pose2 beside = from_outward(standing, {0, 2 * half_width_, 0}, left);
    const Pose2 candidates[] = {wanted, clipped(s_, standing, wanted, left), beside};
    for (int c = 0; c < 3; ++c) {
      const bool at_goal = c == 0;
      if (!may_land(s_, standing, candidates[c], left, at_goal && posture_)) continue;
      Feet next = feet;
      (left ? next.left : next.right) = candidates[c];
      steps_.push_back({left, candidates[c]});
      if (at_goal && same(left ? next.right : next.left, left ? goal_.right : goal_.left)) return true;
      if (search(next, !left, depth - 1)) return true;
      steps_.pop_back();
    }
    return false;
  }

  Feet goal_;
  bool posture_;
  double half_width_;
  StepSettings s_;
  std::vector<Footstep> steps_;
};

std::vector<Pose2> waypoints(const std::vector<Pose2>& path) {
  std::vector<Pose2> points{path.front()};
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Pose2 &a = path[i], &b = path[i + 1];
    const double way = std::hypot(b.x - a.x, b.y - a.y) / kWaypointDistance;
    const double turn = std::abs(wrap_angle(b.yaw - a.yaw)) / kWaypointTurn;
    const int n = std::max(1, static_cast<int>(std::ceil(std::max(way, turn))));
    for (int k = 1; k <= n; ++k) points.push_back(interpolate(a, b, static_cast<double>(k) / n));
  }
  return points;
}

// Along the path from its stance at the beginning to its stance at the end: each foot goes as far as its limits allow.
std::vector<Footstep> follow(const std::vector<Pose2>& points, double half_width, const StepSettings& s,
                             bool first_left) {
  std::vector<Footstep> steps;
  Feet feet = stance(points.front(), half_width);
  std::size_t at_left = 0, at_right = 0;  // waypoint that each foot has reached
  bool left = first_left;
  int without_progress = 0;
  while (at_left + 1 < points.size() || at_right + 1 < points.size()) {
    require(static_cast<int>(steps.size()) < s.most_steps, ErrorCode::walk_no_path,
            "the way needs more than " + std::to_string(s.most_steps) + " steps");
    std::size_t& reached = left ? at_left : at_right;
    const std::size_t abreast = left ? at_right : at_left;  // beside the standing foot: always within the limits
    const Pose2& standing = left ? feet.right : feet.left;
    Pose2& moving = left ? feet.left : feet.right;
    std::size_t best = abreast;
    while (best + 1 < points.size()) {
      const Feet there = stance(points[best + 1], half_width);
      if (!may_land(s, standing, left ? there.left : there.right, left, false)) break;
      ++best;
    }
    const Feet there = stance(points[best], half_width);
    without_progress = best == abreast ? without_progress + 1 : 0;
    require(without_progress < 3, ErrorCode::walk_no_path,
            "the feet cannot follow the path within the step limits; widen walk_planner's step limits");
    reached = best;
    moving = left ? there.left : there.right;
    steps.push_back({left, moving});
    left = !left;
  }
  return steps;
}

// The last landing of each foot is the goal to the bit, not the same place computed along another way.
void snap(std::vector<Footstep>& steps, const Feet& goal) {
  for (const bool left : {true, false}) {
    const auto last = std::find_if(steps.rbegin(), steps.rend(), [left](const Footstep& s) { return s.left == left; });
    if (last != steps.rend()) last->sole = left ? goal.left : goal.right;
  }
}

void append(std::vector<Footstep>& to, const std::vector<Footstep>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

std::optional<bool> next_foot(const std::vector<Footstep>& steps) {
  if (steps.empty()) return std::nullopt;
  return !steps.back().left;
}

}  // namespace

void StepSettings::check() const {
  for (const StepRegion* r : {&step, &posture}) {
    require(r->x_min < 0 && r->x_max > 0 && r->y_min > 0 && r->y_min < r->y_max && r->yaw_out > 0 && r->yaw_in > 0,
            ErrorCode::bad_input,
            "a step region must hold the foot beside the standing one: x_min < 0 < x_max, 0 < y_min < y_max");
  }
  require(clearance > 0 && clearance <= step.y_min, ErrorCode::bad_input,
          "clearance must lie between 0 and the least step width");
  require(most_steps > 0 && most_steps <= 1024, ErrorCode::bad_input, "most_steps must be 1 to 1024");
}

Feet stance(const Pose2& body, double half_width) {
  return {compose(body, {0, half_width, 0}), compose(body, {0, -half_width, 0})};
}

Pose2 outward(const Pose2& standing, const Pose2& moving, bool moving_left) {
  const Pose2 p = compose(inverse(standing), moving);
  const double side = moving_left ? 1 : -1;
  return {p.x, side * p.y, side * p.yaw};
}

bool may_land(const StepSettings& s, const Pose2& standing, const Pose2& moving, bool moving_left, bool posture) {
  const StepRegion& r = posture ? s.posture : s.step;
  const Pose2 p = outward(standing, moving, moving_left);
  const Pose2 back = outward(moving, standing, !moving_left);
  return p.x >= r.x_min - kSlack && p.x <= r.x_max + kSlack && p.y >= r.y_min - kSlack && p.y <= r.y_max + kSlack &&
         p.yaw <= r.yaw_out + kSlack && p.yaw >= -r.yaw_in - kSlack && back.y >= s.clearance - kSlack;
}

std::vector<Footstep> plan_footsteps(const Feet& start, const Feet& goal, const std::vector<Pose2>& path,
                                     double half_width, const StepSettings& settings) {
  settings.check();
  require(!path.empty(), ErrorCode::bad_input, "footsteps need a path of at least one pose");
  require(2 * half_width >= settings.step.y_min && 2 * half_width <= settings.step.y_max, ErrorCode::bad_input,
          "the half-sitting stance must lie within the step limits");
  if (same(start, goal)) return {};

  // Near enough: straight from one arrangement to the other.
  const Pose2 from = middle(start), to = middle(goal);
  if (std::hypot(to.x - from.x, to.y - from.y) < 0.25 && std::abs(wrap_angle(to.yaw - from.yaw)) < 0.35) {
    if (auto steps = Transition(goal, true, half_width, settings).find(start, std::nullopt)) {
      snap(*steps, goal);
      return *steps;
    }
  }

  const std::vector<Pose2> points = waypoints(path);
  std::optional<std::vector<Footstep>> best;
  for (const bool begin_left : {true, false}) {
    const auto opening =
        Transition(stance(points.front(), half_width), false, half_width, settings).find(start, begin_left);
    require(opening.has_value(), ErrorCode::walk_no_path,
            "the feet cannot step from where they stand to the half-sitting stance");
    std::vector<Footstep> steps = *opening;
    append(steps, follow(points, half_width, settings, next_foot(steps).value_or(begin_left)));
    const Feet arrived = stance(points.back(), half_width);
    auto closing = Transition(goal, true, half_width, settings).find(arrived, next_foot(steps));
    require(closing.has_value(), ErrorCode::walk_no_path,
            "the feet of the goal posture stand where no step within the limits can put them; choose another posture");
    append(steps, *closing);
    if (!best || steps.size() < best->size()) best = std::move(steps);
  }
  require(static_cast<int>(best->size()) <= settings.most_steps, ErrorCode::walk_no_path,
          "the way needs " + std::to_string(best->size()) + " steps, more than are allowed");
  snap(*best, goal);
  return *best;
}

}  // namespace periplus::walk
