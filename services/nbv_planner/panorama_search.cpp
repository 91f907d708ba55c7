#include "services/nbv_planner/panorama_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>

#include "common/core/error.h"
#include "common/object_model/object_model.h"
#include "common/voxel/coarsen.h"
#include "services/nbv_planner/local_search.h"
#include "services/nbv_planner/orientation.h"
#include "services/nbv_planner/search_frame.h"

namespace periplus::nbv {
namespace {

constexpr double kRadian = std::numbers::pi / 180;  // of a degree
constexpr int kLeastPlaces = 16;          // looked around from before time may run out: somewhere there is a view then
constexpr double kPanoramaPixels = 5;     // a voxel's width in a panorama, at kPanoramaDistance, where that is coarser than the camera
constexpr double kPanoramaDistance = 1.2; // [m]
constexpr double kGreatestFocal = 1300;   // keeps a panorama under 4096 px [px]
constexpr double kHalfWidth = 57 * kRadian, kHalfHeight = 50 * kRadian;  // of a panorama, at most
constexpr double kWidePixels = 12;        // a voxel's width in a wide rendering at 1 m, at least
constexpr double kCoarseWidePixels = 6;   // of one of the coarse grid
constexpr double kWideMargin = 0.04;      // tangent of what a wide rendering shows beyond the camera's image
constexpr double kPanoramaNear = 0.2;     // along a panorama's own axis [m]
constexpr double kDepthSlack = 0.12;      // of the depth range of a wide rendering, whose axis is not yet the view's [m]
constexpr double kApart = 0.08;           // places that are looked at with both eyes [m]
constexpr double kFineApart = 0.08;     // places of the coarse grid that are looked at in the fine one [m]
constexpr double kLevelled = 14 * kRadian;  // of a view that is tried from as high as what it looks at
constexpr PlaceSampling kPlaces{.height_share = 1, .nearness = 1.5, .ordered = true};
constexpr double kUsualBox = 1.2;         // horizontal diagonal of a box that the numbers of the settings are for [m]
constexpr double kVeryMuch = 5;           // times much_from: from there on fewer places are searched
constexpr double kFewPlaces = 1.7, kMostPlaces = 4;  // times as many positions with fewer faces than much_from
constexpr double kWorst = -1e9;

// A place between the eyes with the orientation that was chosen there.
struct Look {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  double yaw = 0, pitch = 0, roll = 0;
  double value = kWorst;  // of the list, less the penalties
  bool feasible = false;
  int evaluations = 0;

  Angles angles() const { return {yaw, pitch, roll}; }
  void set(const Aim& aim) {
    yaw = aim.angles.yaw;
    pitch = aim.angles.pitch;
    roll = aim.angles.roll;
    value = aim.value;
  }
};
template <class Fields>
void visit_fields(Fields& fields, Look& l) {
  fields(l.p_W, l.yaw, l.pitch, l.roll, l.value, l.feasible, l.evaluations);
}

struct Exact {
  std::optional<Candidate> best;
  int evaluations = 0;
};
template <class Fields>
void visit_fields(Fields& fields, Exact& e) {
  fields(e.best, e.evaluations);
}

class PanoramaSearch {
 public:
  PanoramaSearch(SearchFrame& frame, const PanoramaSettings& settings) : frame_(frame), settings_(with_effort(settings, frame.evaluator)) {
    const Evaluator& e = frame.evaluator;
    const PairWindow window = PairWindow::of(frame.situation.rig, e.settings().pair);
    for (int i = 0; i < frame.runner.workers(); ++i) workers_.push_back({OrientationSearch(window, frame.situation.limits), {}, OrientationCost(e)});
    if (much(settings, e)) {
      coarse_.emplace(voxel::coarsen(*e.judged().grid), object_model::occluders_of(frame.situation.scene), coarse_marks());
    }
    // A point in a view's window lies no farther than this, along any axis.
    list_depth_max_ = window.depth_max * std::sqrt(1 + window.tan_horizontal * window.tan_horizontal + window.tan_vertical * window.tan_vertical);
    find_unknown_box();
    const double h = e.visibility().geometry().voxel_size;
    wide_ = wide_camera(h, kWidePixels);
    coarse_wide_ = wide_camera(2 * h, kCoarseWidePixels);
  }

  PlannedView run() {
    const int budget = frame_.left();
    look_around(std::clamp(settings_.positions, 1, std::max(4, budget / 2)));
    frame_.end_stage("panoramas", 0.3);
    if (!frame_.faces.empty()) {
      double radius = settings_.radius;
      for (int round = 0; round < settings_.rounds; ++round, radius *= 0.55) perturb(round, radius, budget * 3 / 4);
      frame_.end_stage("perturbation", 0.5);
    }
    std::vector<Look> looks = both_eyes();
    frame_.end_stage("both eyes", 0.6);
    if (!frame_.faces.empty()) {
      polish(spread(looks, settings_.starts, 0.15), settings_.position_evaluations, 0.1, 0.06, true);
      // Fewer each time, with a smaller step.
      level();
      if (coarse_) look_finely();
      looks = looks_;
      int finalists = settings_.finalists;
      double step = 0.05;
      for (int round = 0; round < settings_.final_rounds; ++round, finalists = std::max(1, finalists / 2), step *= 0.6) {
        looks = polish(spread(looks, finalists, step), settings_.final_evaluations, step, 0.08, false);
      }
    }
    frame_.end_stage("positions", 0.8);
    exact(looks);
    frame_.end_stage("exact", 1);
    if (!frame_.best) last_resort();
    return frame_.finish();
  }

 private:
  static bool much(const PanoramaSettings& s, const Evaluator& evaluator) {
    return evaluator.visibility().unknown_face_count() >= static_cast<std::size_t>(s.much_from);
  }

  // panorama_search.h, PanoramaSettings: what the numbers stand for depends on what is to be seen.
  static PanoramaSettings with_effort(PanoramaSettings s, const Evaluator& evaluator) {
    const voxel::GridGeometry& g = evaluator.visibility().geometry();
    const double faces = std::max<double>(1, static_cast<double>(evaluator.visibility().unknown_face_count()));
    const auto scale = [](std::initializer_list<int*> numbers, double factor) {
      for (int* n : numbers) *n = static_cast<int>(std::ceil(*n * factor));
    };
    scale({&s.positions, &s.kept, &s.wide, &s.starts, &s.finalists}, std::clamp(g.size.head<2>().cast<double>().norm() * g.voxel_size / kUsualBox, 1.0, 2.0));
    if (much(s, evaluator)) {
      scale({&s.wide, &s.starts, &s.finalists}, std::clamp(kVeryMuch * s.much_from / faces, 0.5, 1.0));
    } else {
      const double fewer = s.much_from / faces;
      scale({&s.positions}, std::clamp(kFewPlaces * fewer, kFewPlaces, kMostPlaces));
      scale({&s.final_rounds}, 2);
      scale({&s.exact_evaluations}, 3);
      scale({&s.exact}, std::clamp(0.75 * fewer, 0.5, 2.0));
    }
    return s;
  }

  // Shows more than the camera, so that the view may still be turned.
  struct WideCamera {
    Pinhole camera;
    double scale = 1;
  };
  struct Worker {
    OrientationSearch orientation;
    VisibleList list;
    OrientationCost cost;
  };

  // The coarse one only where there is one.
  ListScene scene(bool coarse) const { return coarse && coarse_ ? ListScene(frame_.evaluator, *coarse_) : ListScene(frame_.evaluator); }

  bool feasible(const Look& look) const {
    return frame_.evaluator.constraints().check(left_eye(look.p_W, look.angles(), frame_.situation.rig.baseline)) == Violation::none;
  }

  std::vector<Eigen::Vector3i> coarse_marks() const {
    std::vector<Eigen::Vector3i> voxels;
    for (const auto& l : frame_.situation.landmarks) {
      if (l.p_W.allFinite()) voxels.push_back(frame_.situation.grid->geometry().voxel_of(l.p_W) / 2);
    }
    return voxels;
  }

  // The box of the unknown voxels that can be seen, or of the whole grid if there are none; world corners.
  void find_unknown_box() {
    const voxel::GridGeometry& g = frame_.evaluator.visibility().geometry();
    Eigen::Vector3i low = g.size, high = Eigen::Vector3i::Zero();
    for (const auto& face : frame_.faces) {
      const Eigen::Vector3i v = frame_.evaluator.visibility().voxel(face.voxel);
      low = low.cwiseMin(v);
      high = high.cwiseMax(v + Eigen::Vector3i::Ones());
    }
    if (frame_.faces.empty()) {
      low.setZero();
      high = g.size;
    }
    low = (low - Eigen::Vector3i::Constant(4)).cwiseMax(0);  // not every face is in the list
    high = (high + Eigen::Vector3i::Constant(4)).cwiseMin(g.size);
    for (int c = 0; c < 8; ++c) {
      const Eigen::Vector3i v(c & 1 ? high.x() : low.x(), c & 2 ? high.y() : low.y(), c & 4 ? high.z() : low.z());
      corners_.push_back(g.X_WG * (v.cast<double>() * g.voxel_size));
    }
    middle_ = (corners_.front() + corners_.back()) / 2;
  }

  WideCamera wide_camera(double voxel_size, double voxel_pixels) const {
    const Pinhole& camera = frame_.situation.rig.camera;
    WideCamera wide;
    wide.scale = std::clamp(voxel_pixels / (voxel_size * camera.fx), 0.35, 1.0);
    wide.camera.fx = camera.fx * wide.scale;
    wide.camera.fy = camera.fy * wide.scale;
    wide.camera.width = static_cast<int>(2 * (camera.width / 2.0 / camera.fx + kWideMargin) * wide.camera.fx) / 2 * 2;
    wide.camera.height = static_cast<int>(2 * (camera.height / 2.0 / camera.fy + kWideMargin) * wide.camera.fy) / 2 * 2;
    wide.camera.cx = (wide.camera.width - 1) / 2.0;
    wide.camera.cy = (wide.camera.height - 1) / 2.0;
    return wide;
  }

  // Pixels that a voxel must show more than, at that share of the camera's focal length.
  int threshold(double scale, const ListScene& of) const {
    return static_cast<int>(std::lround(frame_.evaluator.settings().pair.more_than_pixels * scale * scale * of.pixels()));
  }

  // The best orientation at a place, from one rendering of all the unknown.
  Look panorama(const Eigen::Vector3d& p_W, double last_step, int worker) {
    const Pinhole& camera = frame_.situation.rig.camera;
    Worker& w = workers_[worker];
    voxel::VisibilityWorkspace& visibility = frame_.workspaces[worker].visibility;
    const Eigen::Vector3d d = middle_ - p_W;
    const double pitch = std::clamp(std::atan2(-d.z(), std::hypot(d.x(), d.y())), -20 * kRadian, 50 * kRadian);
    const Pose X_WP = look_along(p_W, std::atan2(d.y(), d.x()), pitch);
    const double limit_u = std::tan(kHalfWidth), limit_v = std::tan(kHalfHeight);
    double u0 = limit_u, u1 = -limit_u, v0 = limit_v, v1 = -limit_v;
    for (const Eigen::Vector3d& corner : corners_) {
      const Eigen::Vector3d q = X_WP.inverse() * corner;
      if (q.z() < 0.15) {
        u0 = v0 = -1e9;
        u1 = v1 = 1e9;
        break;
      }
      u0 = std::min(u0, q.x() / q.z());
      u1 = std::max(u1, q.x() / q.z());
      v0 = std::min(v0, q.y() / q.z());
      v1 = std::max(v1, q.y() / q.z());
    }
    const ListScene of = scene(true);
    const double h = of.voxel_size();
    const double focal = std::min({camera.fx, kPanoramaPixels * kPanoramaDistance / h, kGreatestFocal});
    u0 = std::clamp(u0, -limit_u, limit_u - 0.1);
    u1 = std::clamp(u1, u0 + 0.1, limit_u);
    v0 = std::clamp(v0, -limit_v, limit_v - 0.1);
    v1 = std::clamp(v1, v0 + 0.1, limit_v);
    Pinhole wide;
    wide.fx = wide.fy = focal;
    wide.cx = 1 - u0 * focal;
    wide.cy = 1 - v0 * focal;
    wide.width = static_cast<int>(wide.cx + u1 * focal) + 2;
    wide.height = static_cast<int>(wide.cy + v1 * focal) + 2;
    const double scale = focal / camera.fx;
    of.scene().evaluate(X_WP, wide, {kPanoramaNear, list_depth_max_, threshold(scale, of), true}, visibility, visibility.left);
    const auto& seen = visibility.left;
    w.list.simd = visibility.simd;
    w.list.take({seen.unknown.begin(), seen.unknown.end()}, scale, p_W, of);
    w.cost.place(p_W, {seen.watched.begin(), seen.watched.end()}, scale, frame_.greatest, of);
    Look look;
    look.p_W = p_W;
    look.evaluations = 1;
    const Aim aim = w.orientation.histogram(w.list, w.cost, d);
    look.set(w.orientation.compass(w.list, w.cost, aim, 3 * kRadian, last_step));
    look.feasible = feasible(look);
    return look;
  }

  // Both eyes rendered wider than their images around an orientation, and the best orientation for what both see.
  Look pair(const Eigen::Vector3d& p_W, const Angles& around, double first, double last, bool kicks, int worker, bool coarse) {
    Worker& w = workers_[worker];
    voxel::VisibilityWorkspace& visibility = frame_.workspaces[worker].visibility;
    const double baseline = frame_.situation.rig.baseline;
    const Pose X_left = left_eye(p_W, around, baseline);
    const ListScene of = scene(coarse);
    const auto& [camera, scale] = coarse && coarse_ ? coarse_wide_ : wide_;
    const voxel::ViewOptions options{frame_.evaluator.settings().pair.depth_min - kDepthSlack, frame_.evaluator.settings().pair.depth_max + kDepthSlack,
                                     threshold(scale, of), true};
    of.scene().evaluate(X_left, camera, options, visibility, visibility.left);
    const auto& left = visibility.left;
    w.list.simd = visibility.simd;
    if (baseline > 0) {
      of.scene().evaluate(X_left * Pose(Eigen::Translation3d(baseline, 0, 0)), camera, options, visibility, visibility.right);
      const auto& right = visibility.right;
      w.list.take_both({left.unknown.begin(), left.unknown.end()}, {right.unknown.begin(), right.unknown.end()}, scale, p_W, of);
    } else {
      w.list.take({left.unknown.begin(), left.unknown.end()}, scale, p_W, of);
    }
    w.cost.place(p_W, {left.watched.begin(), left.watched.end()}, scale, frame_.greatest, of);
    Look look;
    look.p_W = p_W;
    look.evaluations = 1;
    Aim aim = w.orientation.compass(w.list, w.cost, w.orientation.evaluate(w.list, w.cost, around), first, last);
    if (kicks) aim = w.orientation.kicks(w.list, w.cost, aim, last);
    look.set(aim);
    look.feasible = feasible(look);
    return look;
  }

  void take(const std::vector<std::optional<Look>>& looks, const char* stage) {
    for (const auto& l : looks) {
      if (!l) continue;
      frame_.evaluations += l->evaluations;
      if (!l->feasible) continue;
      looks_.push_back(*l);
      frame_.note(left_eye(l->p_W, l->angles(), frame_.situation.rig.baseline), -l->value, stage);
    }
  }

  void look_around(int count) {
    // With time out before anything feasible was found, on it goes: that no place is reachable must be true when it is said.
    for (int begun = 0; looks_.empty() && begun < count;) {
      const auto looks = frame_.runner.map<Look>(
          count - begun,
          [&](int i, int worker) {
            Random random = frame_.random(0, begun + i);
            const auto place = frame_.draw_place(begun + i, kPlaces, random);
            return place ? panorama(place->p_W, 2.9 * kRadian, worker) : Look{};
          },
          kLeastPlaces);
      for (const auto& l : looks) begun += l.has_value();
      take(looks, "panoramas");
    }
    if (looks_.empty()) frame_.throw_unreachable();
    update_scale();
  }

  void update_scale() {
    for (const Look& l : looks_) frame_.greatest = std::max(frame_.greatest, l.value);
  }

  // The first `count` by value, at least `apart` from each other in position and half-turns of the axis.
  static std::vector<Look> spread(std::vector<Look> looks, int count, double apart) {
    std::stable_sort(looks.begin(), looks.end(), [](const Look& a, const Look& b) { return a.value > b.value; });
    std::vector<Look> chosen;
    for (const Look& l : looks) {
      if (static_cast<int>(chosen.size()) >= count) break;
      const bool close = std::any_of(chosen.begin(), chosen.end(), [&](const Look& o) {
        const double turn = 0.5 * wrap_angle(o.yaw - l.yaw), tilt = 0.5 * (o.pitch - l.pitch);
        return (o.p_W - l.p_W).squaredNorm() + turn * turn + tilt * tilt < apart * apart;
      });
      if (!close) chosen.push_back(l);
    }
    return chosen;
  }

  void perturb(int round, double radius, int until_left) {
    const std::vector<Look> around = spread(looks_, settings_.kept, radius * 0.6);
    const robot::ViewLimits& l = frame_.situation.limits;
    const int room = std::max(0, frame_.left() - (frame_.settings.max_evaluations - until_left));
    const int count = std::min(static_cast<int>(around.size()) * settings_.each, room);
    const auto looks = frame_.runner.map<Look>(count, [&](int i, int worker) {
      Random random = frame_.random(1 + round, i);
      const Look& from = around[i / settings_.each];
      Eigen::Vector3d p = from.p_W + radius * Eigen::Vector3d(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), random.uniform(-1, 1));
      p.z() = std::clamp(p.z(), l.height_min, l.height_max);
      frame_.move_back(p, from.yaw);
      if (frame_.evaluator.constraints().check_position(p, from.yaw) != Violation::none) return Look{};
      return panorama(p, 1.4 * kRadian, worker);
    });
    take(looks, "perturbation");
    update_scale();
  }

  std::vector<Look> both_eyes() {
    const std::vector<Look> around = spread(looks_, std::max(1, std::min(settings_.wide, frame_.left() / 3)), kApart);
    look_again(around, "both eyes", [&](const Look& l, int worker) { return pair(l.p_W, l.angles(), 4 * kRadian, 0.9 * kRadian, true, worker, true); });
    update_scale();
    return looks_;
  }

  // Takes what becomes of looks in the place of all so far; where that is nothing, as they are.
  template <class Again>
  void look_again(const std::vector<Look>& looks, const char* stage, const Again& again) {
    const auto results = frame_.runner.map<Look>(static_cast<int>(looks.size()), [&](int i, int worker) { return again(looks[i], worker); }, 1);
    looks_.clear();
    take(results, stage);
    if (looks_.empty()) looks_ = looks;
  }

  // Nelder-Mead over x, y, z from each, with the orientation chosen at each position; results with those that were improved.
  std::vector<Look> polish(const std::vector<Look>& starts, int evaluations, double step, double end, bool coarse) {
    if (starts.empty()) return starts;
    const int budget = std::min(evaluations, frame_.left() * 2 / 3 / static_cast<int>(starts.size()));
    if (budget < 5) return starts;
    const auto looks = frame_.runner.map<Look>(static_cast<int>(starts.size()), [&](int i, int worker) {
      return polish_one(starts[i], budget, step, end, coarse, worker);
    });
    looks_.clear();
    take(looks, "positions");
    for (std::size_t i = 0; i < starts.size(); ++i) {
      if (!looks[i]) looks_.push_back(starts[i]);
    }
    return looks_;
  }

  // The best of the coarse grid, in the fine one.
  void look_finely() {
    const std::vector<Look> best = spread(looks_, std::clamp(frame_.left() / 3, 1, 2 * settings_.finalists + 8), kFineApart);
    look_again(best, "fine", [&](const Look& l, int worker) { return pair(l.p_W, l.angles(), 1.2 * kRadian, 0.15 * kRadian, false, worker, false); });
  }

  // From as high as what is looked at: of the best that look a little up or down.
  void level() {
    std::vector<Look> starts;
    for (const Look& s : spread(looks_, settings_.finalists, 0.1)) {
      if (static_cast<int>(starts.size()) >= frame_.left() / 4) break;
      if (s.pitch != 0 && std::abs(s.pitch) < kLevelled) starts.push_back(s);
    }
    const auto found = frame_.runner.map<Look>(static_cast<int>(starts.size()), [&](int i, int worker) {
      const Look& s = starts[i];
      const Eigen::Vector3d p = levelled(s);
      if (frame_.evaluator.constraints().check_position(p, s.yaw) != Violation::none) return Look{};
      return pair(p, {s.yaw, 0, s.roll}, 0.6 * kRadian, 0.3 * kRadian, false, worker, true);
    });
    take(found, "level");
  }

  // As high as what is looked at.
  Eigen::Vector3d levelled(const Look& look) const {
    const robot::ViewLimits& l = frame_.situation.limits;
    Eigen::Vector3d p = look.p_W;
    p.z() = std::clamp(p.z() - target_distance(look) * std::tan(look.pitch), l.height_min, l.height_max);
    return p;
  }

  // What a view looks at lies about so far away [m].
  double target_distance(const Look& look) const { return std::clamp(frame_.evaluator.constraints().nearest_voxel(look.p_W) + 0.1, 0.6, 2.5); }

  Look polish_one(const Look& start, int budget, double step, double end, bool coarse, int worker) {
    const robot::ViewLimits& l = frame_.situation.limits;
    Look best = start;
    int evaluations = 0;
    const Eigen::Vector3d forward(std::cos(start.yaw), std::sin(start.yaw), 0), left(-forward.y(), forward.x(), 0);
    // What the start looks at: further positions begin with it in the middle.
    const double distance = target_distance(start);
    const auto value = [&](const std::vector<double>& x) {
      if (x[0] == 0 && x[1] == 0 && x[2] == 0) return -start.value;  // looked at already
      Eigen::Vector3d p = start.p_W + x[0] * forward + x[1] * left + Eigen::Vector3d(0, 0, x[2]);
      p.z() = std::clamp(p.z(), l.height_min, l.height_max);
      if (frame_.evaluator.constraints().check_position(p, best.yaw) != Violation::none) {
        const double d = frame_.evaluator.constraints().nearest_voxel(p);
        return frame_.greatest * (1 + std::max({0.0, l.distance_min - d, d - l.distance_max}));
      }
      const Eigen::Vector3d d = best.p_W + distance * best.angles().forward() - p;
      const Angles around{std::atan2(d.y(), d.x()), std::clamp(std::atan2(-d.z(), std::hypot(d.x(), d.y())), l.pitch_min, l.pitch_max), best.roll};
      const Look look = pair(p, around, 2.4 * kRadian, 0.15 * kRadian, false, worker, coarse);
      ++evaluations;
      if (!look.feasible) return frame_.greatest;
      if (look.value > best.value) best = look;
      return -look.value;
    };
    LocalSearchOptions options;
    options.method = LocalMethod::nelder_mead;
    const double up = start.p_W.z() > (l.height_min + l.height_max) / 2 ? -0.7 : 0.7;
    options.step = {step, step, step * up};
    options.lower = {-2, -2, -2};
    options.upper = {2, 2, 2};
    options.end = end * step;
    options.max_evaluations = budget;
    minimize(value, {0, 0, 0}, options);
    best.evaluations = evaluations;
    return best;
  }

  void exact(const std::vector<Look>& looks) {
    std::vector<Pose> poses;
    for (const Look& l : spread(looks, std::max(settings_.exact, 2), 0.02)) {
      poses.push_back(left_eye(l.p_W, l.angles(), frame_.situation.rig.baseline));
      if (l.pitch != 0 && std::abs(l.pitch) < kLevelled) poses.push_back(left_eye(levelled(l), {l.yaw, 0, l.roll}, frame_.situation.rig.baseline));
    }
    std::vector<Candidate> candidates = frame_.evaluate(poses, 1);
    for (const Candidate& c : candidates) {
      frame_.offer(c);
      frame_.note(c.X_WC, frame_.score(c.evaluation), "exact");
    }
    if (frame_.faces.empty() || settings_.exact == 0 || candidates.empty()) return;
    std::stable_sort(candidates.begin(), candidates.end(), [&](const Candidate& a, const Candidate& b) { return frame_.better(a, b); });
    if (static_cast<int>(candidates.size()) > settings_.exact) candidates.resize(settings_.exact);
    const int budget = std::min(settings_.exact_evaluations, frame_.left() / static_cast<int>(candidates.size()));
    if (budget < 16) return;
    // With fewer searches than threads each eye has one of its own.
    for (Evaluator::Workspace& w : frame_.workspaces) {
      if (frame_.runner.workers() > static_cast<int>(candidates.size())) w.visibility.beside = std::make_unique<voxel::VisibilityWorkspace>();
    }
    const auto results = frame_.runner.map<Exact>(static_cast<int>(candidates.size()), [&](int i, int worker) {
      Exact e;
      Candidate at = candidates[i];
      for (double scale : {0.4, 0.16}) refine(at, scale, budget / 2, e, worker);
      return e;
    });
    for (const auto& r : results) {
      if (!r) continue;
      frame_.evaluations += r->evaluations;
      if (!r->best) continue;
      frame_.offer(*r->best);
      frame_.note(r->best->X_WC, frame_.score(r->best->evaluation), "exact");
    }
  }

  // Nelder-Mead in all degrees of freedom on the exact evaluation.
  void refine(Candidate& at, double scale, int budget, Exact& result, int worker) {
    const robot::ViewLimits& l = frame_.situation.limits;
    const double baseline = frame_.situation.rig.baseline;
    const Eigen::Vector3d p = middle_of_eyes(at.X_WC, baseline), ypr = camera_yaw_pitch_roll(at.X_WC);
    const bool level = std::abs(ypr.y()) < 1e-9;  // then it stays so
    const double score_at_start = frame_.score(at.evaluation);
    const auto value = [&](const std::vector<double>& x) {
      if (std::all_of(x.begin(), x.end(), [](double v) { return v == 0; })) return score_at_start;
      const double pitch = level ? 0 : std::clamp(ypr.y() + x[4], l.pitch_min, l.pitch_max);
      const double roll = l.roll_max > 0 ? std::clamp(ypr.z() + x.back(), -l.roll_max, l.roll_max) : 0;
      Candidate c{left_eye({p.x() + x[0], p.y() + x[1], std::clamp(p.z() + x[2], l.height_min, l.height_max)}, {ypr.x() + x[3], pitch, roll}, baseline), {}};
      if (frame_.evaluator.constraints().check(c.X_WC) != Violation::none) return frame_.greatest;
      c.evaluation = frame_.evaluator.evaluate(c.X_WC, frame_.workspaces[worker]);
      ++result.evaluations;
      frame_.offer(c, result.best);
      const double score = frame_.score(c.evaluation);
      if (score < frame_.score(at.evaluation)) at = c;
      return score;
    };
    LocalSearchOptions options;
    options.method = LocalMethod::nelder_mead;
    const double up = p.z() > (l.height_min + l.height_max) / 2 ? -0.08 : 0.08;
    options.step = {0.1 * scale, 0.1 * scale, up * scale, 0.07 * scale};
    if (!level) options.step.push_back(0.07 * scale);
    if (l.roll_max > 0) options.step.push_back(std::min(0.06, l.roll_max) * scale * (ypr.z() > 0 ? -1 : 1));
    const std::size_t n = options.step.size();
    options.lower.assign(n, -2);
    options.upper.assign(n, 2);
    options.end = 0.002 * scale;
    options.max_evaluations = budget;
    minimize(value, std::vector<double>(n, 0.0), options);
  }

  // Nothing of what was chosen is feasible exactly: the panoramas' own orientations, which were checked.
  void last_resort() {
    for (const Look& l : looks_) {
      const Pose X_WC = left_eye(l.p_W, l.angles(), frame_.situation.rig.baseline);
      frame_.offer({X_WC, frame_.evaluator.evaluate(X_WC, frame_.workspaces[0])});
      ++frame_.evaluations;
      if (frame_.best) return;
    }
    frame_.throw_unreachable();
  }

  SearchFrame& frame_;
  const PanoramaSettings settings_;
  std::optional<voxel::VisibilityScene> coarse_;  // what all but the last stages look at, if much is unknown
  std::vector<Worker> workers_;
  std::vector<Eigen::Vector3d> corners_;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  WideCamera wide_, coarse_wide_;
  double list_depth_max_ = 0;
  std::vector<Look> looks_;  // feasible ones of the last stages
};

}  // namespace

PanoramaSettings PanoramaSettings::fast() {
  PanoramaSettings s;
  s.positions = 160;
  s.kept = 12;
  s.wide = 24;
  s.starts = 12;
  s.position_evaluations = 9;
  s.finalists = 5;
  s.final_evaluations = 12;
  s.exact = 1;
  s.exact_evaluations = 36;
  return s;
}

PanoramaSettings PanoramaSettings::thorough() { return {}; }

void check(const PanoramaSettings& s) {
  require(s.positions >= 1 && s.rounds >= 0 && s.kept >= 1 && s.each >= 1 && s.radius > 0 && s.wide >= 1 && s.starts >= 1 && s.finalists >= 1,
          ErrorCode::bad_input, "a search from panoramas takes positions, kept, each, wide, starts, finalists of at least 1, rounds of at "
                                "least 0 and a radius above 0");
  require(s.position_evaluations >= 0 && s.final_evaluations >= 0 && s.final_rounds >= 0 && s.exact >= 0 && s.exact_evaluations >= 0, ErrorCode::bad_input,
          "numbers of evaluations and final rounds must be at least 0");
}

PlannedView panorama_search(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& search, const PanoramaSettings& settings,
                            TaskRunner& runner, const std::function<void(double)>& poll) {
  SearchFrame frame(evaluator, seed, search, runner, Bounds::all, poll);
  return PanoramaSearch(frame, settings).run();
}

}  // namespace periplus::nbv
