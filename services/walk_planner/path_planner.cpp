#include "services/walk_planner/path_planner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::walk {
namespace {

std::string text(const Pose2& p) {
  char buffer[96];
  std::snprintf(buffer, sizeof buffer, "(%.2f, %.2f, %.0f deg)", p.x, p.y, p.yaw * 180 / std::numbers::pi);
  return buffer;
}

class Planner {
 public:
  Planner(FloorSpace floor, const Pose2& start, const Pose2& goal, std::uint64_t seed,
          const PathSettings& settings)
      : floor_(std::move(floor)), start_(start), goal_(goal), random_(seed), s_(settings) {}

  Path run() {
    check_end(start_, ErrorCode::walk_start_in_collision, "start");
    check_end(goal_, ErrorCode::walk_goal_in_collision, "goal");
    Path path;
    path.poses = direct(start_, goal_);
    if (path.poses.empty()) {
      path.poses = connect_trees(path.samples);
      shorten(path.poses);
    }
    return path;
  }

 private:
  struct TreeNode {
    Pose2 pose;
    int parent;
  };
  using Tree = std::vector<TreeNode>;

  double distance(const Pose2& a, const Pose2& b) const {
    const double turn = s_.yaw_weight * wrap_angle(b.yaw - a.yaw);
    return std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y) + turn * turn);
  }
  double shrink_at(const Pose2& p) const {
    const double to_end =
        std::min(std::hypot(p.x - start_.x, p.y - start_.y), std::hypot(p.x - goal_.x, p.y - goal_.y));
    return to_end <= s_.end_radius ? s_.end_shrink : 0.0;
  }
  bool free(const Pose2& p) const { return floor_.blocked(p, shrink_at(p)) == Blocked::no; }

  bool segment_free(const Pose2& a, const Pose2& b) const {
    const double way = std::hypot(b.x - a.x, b.y - a.y), turn = std::abs(wrap_angle(b.yaw - a.yaw));
    const int n = std::max(1, static_cast<int>(std::ceil(std::max(way / s_.check_distance, turn / s_.check_angle))));
    for (int i = 1; i <= n; ++i)
      if (!free(interpolate(a, b, static_cast<double>(i) / n))) return false;
    return true;
  }

  void check_end(const Pose2& p, ErrorCode code, const char* which) const {
    const Blocked by = floor_.blocked(p, s_.end_shrink);
    if (by == Blocked::no) return;
    throw_error(code,
                std::string("the half-sitting robot at the ") + which + " " + text(p) + " touches " +
                    (by == Blocked::by_object ? "the object" : "the environment") +
                    (code == ErrorCode::walk_goal_in_collision ? "; choose another posture" : "; move the robot away"));
  }

  // Straight there, or turning to face the way, walking and turning again: whichever takes fewer steps. Empty if
  // neither is free.
  std::vector<Pose2> direct(const Pose2& a, const Pose2& b) const {
    std::vector<std::vector<Pose2>> ways{{a, b}};
    if (std::hypot(b.x - a.x, b.y - a.y) > 1e-6) {
      const double heading = std::atan2(b.y - a.y, b.x - a.x);
      for (const double facing : {heading, wrap_angle(heading + std::numbers::pi)})
        ways.push_back({a, {a.x, a.y, facing}, {b.x, b.y, facing}, b});
    }
    std::stable_sort(ways.begin(), ways.end(), [](const auto& l, const auto& r) { return cost(l) < cost(r); });
    for (const std::vector<Pose2>& way : ways) {
      bool ok = true;
      for (std::size_t i = 0; ok && i + 1 < way.size(); ++i) ok = segment_free(way[i], way[i + 1]);
      if (ok) return way;
    }
    return {};
  }

  static double cost(const std::vector<Pose2>& way) {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < way.size(); ++i) sum += steps_of(way[i], way[i + 1]);
    return sum;
  }

  int nearest(const Tree& tree, const Pose2& to) const {
    int best = 0;
    double least = distance(tree[0].pose, to);
    for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
      const double d = distance(tree[i].pose, to);
      if (d < least) {
        least = d;
        best = i;
      }
    }
    return best;
  }

  // One branch from `from` towards `to`; index of the new node, or -1 if blocked. `reached` tells whether it got there.
  int extend(Tree& tree, int from, const Pose2& to, bool& reached) const {
    const Pose2 origin = tree[from].pose;
    const double d = distance(origin, to);
    reached = d <= s_.extension;
    const Pose2 end = reached ? to : interpolate(origin, to, s_.extension / d);
    if (!segment_free(origin, end)) return -1;
    tree.push_back({end, from});
    return static_cast<int>(tree.size()) - 1;
  }

  static std::vector<Pose2> branch(const Tree& tree, int leaf) {
    std::vector<Pose2> poses;
    for (int i = leaf; i >= 0; i = tree[i].parent) poses.push_back(tree[i].pose);
    return poses;  // leaf to root
  }

  std::vector<Pose2> connect_trees(int& samples) {
    Tree trees[2] = {{{start_, -1}}, {{goal_, -1}}};
    for (samples = 0; samples < s_.samples;) {
      ++samples;
      const int grown = samples % 2;
      const Pose2 sample{random_.uniform(floor_.lower().x(), floor_.upper().x()),
                         random_.uniform(floor_.lower().y(), floor_.upper().y()),
                         random_.uniform(-std::numbers::pi, std::numbers::pi)};
      bool reached = false;
      const int leaf = extend(trees[grown], nearest(trees[grown], sample), sample, reached);
      if (leaf < 0) continue;
      const Pose2 target = trees[grown][leaf].pose;
      Tree& other = trees[1 - grown];
      int tip = nearest(other, target);
      while (tip >= 0) {
        tip = extend(other, tip, target, reached);
        if (tip < 0 || !reached) continue;
        std::vector<Pose2> to_start = branch(trees[0], grown == 0 ? leaf : tip);
        const std::vector<Pose2> to_goal = branch(trees[1], grown == 1 ? leaf : tip);
        std::reverse(to_start.begin(), to_start.end());
        to_start.insert(to_start.end(), to_goal.begin() + 1, to_goal.end());
        return to_start;
      }
    }
    const bool goal_side = trees[1].size() < trees[0].size();
    throw_error(ErrorCode::walk_no_path,
                "no way found from " + text(start_) + " to " + text(goal_) + " with " + std::to_string(samples) +
                    " samples (the " + (goal_side ? "goal" : "start") +
                    " side reached least: " + std::to_string(std::min(trees[0].size(), trees[1].size())) + " poses)");
  }

  void shorten(std::vector<Pose2>& poses) {
    for (int attempt = 0; attempt < s_.shortcuts && poses.size() > 2; ++attempt) {
      // Two places along the path, each at a share of a segment.
      const std::size_t segments = poses.size() - 1;
      std::size_t i = random_.below(segments), j = random_.below(segments);
      double ti = random_.uniform(), tj = random_.uniform();
      if (attempt % 4 == 0) ti = 0;  // corners themselves, too
      if (attempt % 4 == 0) tj = 1;
      if (i > j) {
        std::swap(i, j);
        std::swap(ti, tj);
      }
      if (i == j) continue;
      const Pose2 a = interpolate(poses[i], poses[i + 1], ti), b = interpolate(poses[j], poses[j + 1], tj);
      std::vector<Pose2> old{a};
      old.insert(old.end(), poses.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                 poses.begin() + static_cast<std::ptrdiff_t>(j) + 1);
      old.push_back(b);
      const std::vector<Pose2> way = direct(a, b);
      if (way.empty() || cost(way) > cost(old) - 0.1) continue;
      std::vector<Pose2> next(poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      const auto append = [&next, this](const Pose2& p) {
        if (distance(next.back(), p) > 1e-9) next.push_back(p);
      };
      for (const Pose2& p : way) append(p);
      for (std::size_t k = j + 1; k < poses.size(); ++k) append(poses[k]);
      poses = std::move(next);
    }
    poses.back() = goal_;
  }

  const FloorSpace floor_;
  Pose2 start_, goal_;
  Random random_;
  PathSettings s_;
};

}  // namespace

void PathSettings::check() const {
  require(yaw_weight > 0 && extension > 0 && check_distance > 0 && check_angle > 0, ErrorCode::bad_input,
          "yaw weight, extension and check distances of the path planner must be positive");
  require(samples > 0 && shortcuts >= 0, ErrorCode::bad_input, "the path planner needs a positive number of samples");
  require(end_radius >= 0 && end_shrink >= 0, ErrorCode::bad_input, "end radius and end shrink must not be negative");
}

double Path::length() const {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < poses.size(); ++i)
    sum += std::hypot(poses[i + 1].x - poses[i].x, poses[i + 1].y - poses[i].y);
  return sum;
}

Pose2 interpolate(const Pose2& a, const Pose2& b, double t) {
  if (t >= 1) return b;
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), wrap_angle(a.yaw + t * wrap_angle(b.yaw - a.yaw))};
}

double steps_of(const Pose2& a, const Pose2& b) {
  const double turn = wrap_angle(b.yaw - a.yaw);
  const double heading = a.yaw + 0.5 * turn;
  const double c = std::cos(heading), s = std::sin(heading);
  const double forward = c * (b.x - a.x) + s * (b.y - a.y), left = -s * (b.x - a.x) + c * (b.y - a.y);
  return std::abs(forward) / (forward > 0 ? 0.20 : 0.15) + std::abs(left) / 0.035 + std::abs(turn) / 0.20;
}

Path plan_path(const FloorSpace& floor, const Pose2& start, const Pose2& goal, std::uint64_t seed,
               const PathSettings& settings) {
  settings.check();
  return Planner(floor.left_from(start, settings.end_shrink), start, goal, seed, settings).run();
}

}  // namespace periplus::walk
