#include "services/nbv_planner/orientation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace periplus::nbv {
namespace {

constexpr double kOrientationPi = std::numbers::pi;
constexpr double kOneDegree = kOrientationPi / 180;
constexpr double kCell = 4 * kOneDegree;
constexpr int kAzimuths = 90, kElevations = 46;  // of the histogram; elevations about the horizon, a cell more at each end
constexpr int kWrapped = 46;                     // azimuths that are there twice
constexpr int kWeightUnit = 256;
constexpr double kNearlyLevel = 4 * kOneDegree;

float dot(const float* a, const Eigen::Vector3f& p) { return a[0] * p.x() + a[1] * p.y() + a[2] * p.z(); }

bool in_window(const WindowPlanes& w, const Eigen::Vector3f& p) {
  const float z = dot(w.forward, p);
  return std::abs(dot(w.right, p)) <= w.tan_horizontal * z - w.half_baseline && std::abs(dot(w.down, p)) <= w.tan_vertical * z &&
         z >= w.depth_min && z <= w.depth_max;
}

}  // namespace

PairWindow PairWindow::of(const StereoRig& rig, const voxel::PairOptions& options) {
  return {rig.camera.width / 2.0 / rig.camera.fx, rig.camera.height / 2.0 / rig.camera.fy, rig.baseline, options.depth_min,
          options.depth_max};
}

WindowPlanes PairWindow::planes(double yaw, double pitch, double roll) const {
  const Eigen::Matrix3f R = look_along(Eigen::Vector3d::Zero(), yaw, pitch, roll).linear().cast<float>();
  WindowPlanes w;
  for (int i = 0; i < 3; ++i) {
    w.right[i] = R(i, 0);
    w.down[i] = R(i, 1);
    w.forward[i] = R(i, 2);
  }
  w.tan_horizontal = static_cast<float>(tan_horizontal);
  w.tan_vertical = static_cast<float>(tan_vertical);
  w.half_baseline = static_cast<float>(baseline / 2);
  w.depth_min = static_cast<float>(depth_min);
  w.depth_max = static_cast<float>(depth_max);
  return w;
}

Eigen::Vector3d Angles::forward() const {
  return {std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), -std::sin(pitch)};
}

Pose left_eye(const Eigen::Vector3d& p_W, const Angles& a, double baseline) {
  return look_along(p_W, a.yaw, a.pitch, a.roll) * Pose(Eigen::Translation3d(-baseline / 2, 0, 0));
}

Eigen::Vector3d middle_of_eyes(const Pose& X_WC, double baseline) { return X_WC * Eigen::Vector3d(baseline / 2, 0, 0); }

template <class Call>
void ListScene::for_each_fine(std::uint32_t voxel, const Call& call) const {
  const Eigen::Vector3i first = scene_.voxel(voxel) * step_;
  const voxel::VisibilityScene& fine = evaluator_.visibility();
  const Eigen::Vector3i end = (first.array() + step_).min(fine.geometry().size.array());
  for (int x = first.x(); x < end.x(); ++x) {
    for (int y = first.y(); y < end.y(); ++y) {
      for (int z = first.z(); z < end.z(); ++z) call(fine.index(Eigen::Vector3i(x, y, z)));
    }
  }
}

double ListScene::weight(std::uint32_t voxel) const {
  if (step_ == 1) return evaluator_.weight(voxel);
  if (!evaluator_.weighted()) return step_ * step_;
  double sum = 0;
  for_each_fine(voxel, [&](std::uint32_t fine) { sum += evaluator_.weight(fine); });
  return sum / step_;  // of those in one layer
}

template <class Call>
void ListScene::for_each_mark(const voxel::VoxelPixels& v, const Call& call) const {
  for_each_fine(v.voxel, [&](std::uint32_t fine) {
    if (const Evaluator::Mark* mark = evaluator_.mark(fine); mark != nullptr) call(fine, v.pixels / double(step_ * step_), *mark);
  });
}

void VisibleList::make_room(int size) {
  const std::size_t room = (static_cast<std::size_t>(size) + 15) / 16 * 16;
  if (x_.size() >= room) return;
  const std::size_t grown = std::max(room, 2 * x_.size());
  x_.resize(grown);
  y_.resize(grown);
  z_.resize(grown);
  weight_.resize(grown);
}

void VisibleList::pad() {
  for (int i = size_; i < (size_ + 15) / 16 * 16; ++i) {
    x_[i] = y_[i] = z_[i] = 0;
    weight_[i] = 0;
  }
}

void VisibleList::add(const Eigen::Vector3f& p, float weight) {
  make_room(size_ + 1);
  x_[size_] = p.x();
  y_[size_] = p.y();
  z_[size_] = p.z();
  weight_[size_++] = static_cast<std::int32_t>(std::lround(weight * kWeightUnit));
  pad();
}

void VisibleList::take(std::span<const voxel::VoxelPixels> seen, double scale, const Eigen::Vector3d& p_W, const ListScene& of) {
  index_.resize(seen.size());
  make_room(static_cast<int>(seen.size()));
  for (std::size_t i = 0; i < seen.size(); ++i) {
    index_[i] = seen[i].voxel;
    weight_[i] = static_cast<std::int32_t>(seen[i].pixels);
  }
  place(static_cast<int>(seen.size()), scale, p_W, of);
}

void VisibleList::take_both(std::span<const voxel::VoxelPixels> left, std::span<const voxel::VoxelPixels> right, double scale,
                            const Eigen::Vector3d& p_W, const ListScene& of) {
  const Eigen::Vector3i& size = of.scene().geometry().size;
  marked_.resize(static_cast<std::size_t>(size.x()) * size.y() * size.z() / 64 + 1, 0);
  for (const voxel::VoxelPixels& v : left) marked_[v.voxel / 64] |= std::uint64_t{1} << v.voxel % 64;
  index_.resize(right.size() + 1);
  make_room(static_cast<int>(right.size()) + 1);
  int n = 0;
  for (const voxel::VoxelPixels& v : right) {
    index_[n] = v.voxel;
    weight_[n] = static_cast<std::int32_t>(v.pixels);
    n += marked_[v.voxel / 64] >> v.voxel % 64 & 1;
  }
  for (const voxel::VoxelPixels& v : left) marked_[v.voxel / 64] = 0;
  place(n, scale, p_W, of);
}

void VisibleList::place(int n, double scale, const Eigen::Vector3d& p_W, const ListScene& of) {
  const voxel::GridGeometry& g = of.scene().geometry();
  VoxelPlacement placement;
  placement.size_y = g.size.y();
  placement.size_z = g.size.z();
  const Eigen::Matrix3d axes = g.X_WG.linear() * g.voxel_size;
  const Eigen::Vector3d origin = g.X_WG.translation() + axes * Eigen::Vector3d::Constant(0.5) - p_W;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) placement.m[r][c] = static_cast<float>(axes(r, c));
    placement.m[r][3] = static_cast<float>(origin[r]);
  }
  place_voxels(index_.data(), n, placement, x_.data(), y_.data(), z_.data(), simd);
  const bool pixels = of.evaluator().settings().quantification == Quantification::pixels;
  if (!pixels && !of.evaluator().weighted()) {
    std::fill_n(weight_.begin(), n, of.pixels() * kWeightUnit);
  } else {
    for (int i = 0; i < n; ++i) {
      const double count = pixels ? weight_[i] / (scale * scale * of.pixels()) : 1;
      weight_[i] = static_cast<std::int32_t>(std::lround(count * of.weight(index_[i]) * kWeightUnit));
    }
  }
  size_ = n;
  pad();
}

PointArrays VisibleList::arrays() const {
  return {x_.data(), y_.data(), z_.data(), weight_.data(), (size_ + 15) / 16 * 16};
}

double VisibleList::sum(const WindowPlanes& window) const { return window_sum(arrays(), window, simd) / double(kWeightUnit); }

Eigen::Vector3d VisibleList::mean(const WindowPlanes& window) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int n = 0;
  for (int i = 0; i < size_; ++i) {
    if (!in_window(window, {x_[i], y_[i], z_[i]})) continue;
    sum += point(i);
    ++n;
  }
  return n == 0 ? sum : Eigen::Vector3d(sum / n);
}

OrientationCost::OrientationCost(const Evaluator& evaluator) : evaluator_(evaluator) {
  const Situation& s = evaluator.situation();
  const Evaluator::Lambdas l = evaluator.lambdas(1);
  idle_ = !evaluator.landmark_term() && s.forbidden.empty() && (l.motion == 0 || !s.X_WC_now) && (l.reach == 0 || !s.reachability);
}

void OrientationCost::place(const Eigen::Vector3d& p_W, std::span<const voxel::VoxelPixels> watched, double scale, double greatest, const ListScene& of) {
  greatest_ = greatest;
  p_W_ = p_W;
  landmarks_.clear();
  if (!evaluator_.landmark_term()) return;
  const voxel::VisibilityScene& scene = evaluator_.visibility();
  for (const voxel::VoxelPixels& v : watched) {
    of.for_each_mark(v, [&](std::uint32_t voxel, double pixels, const Evaluator::Mark& mark) {
      landmarks_.push_back({(scene.geometry().center_world(scene.voxel(voxel)) - p_W).cast<float>(), pixels / (scale * scale), &mark});
    });
  }
}

double OrientationCost::operator()(const Angles& angles, const WindowPlanes& window) const {
  if (idle_) return 0;
  Evaluation e;
  const Pose X_WC = left_eye(p_W_, angles, evaluator_.situation().rig.baseline);
  evaluator_.pose_terms(X_WC, e);
  if (evaluator_.landmark_term()) {
    const Eigen::Vector3d view = angles.forward();
    for (const Seen& s : landmarks_) {
      if (!in_window(window, s.p)) continue;
      e.visible_landmarks += evaluator_.landmark_visibility(s.pixels, s.mark->least_pixels, view, s.mark->normal);
    }
    e.k_landmarks = evaluator_.landmark_penalty(e.visible_landmarks);
  }
  if (evaluator_.constraints().forbidden(X_WC)) e.violation = Violation::forbidden;
  return evaluator_.score(e, greatest_);
}

Angles OrientationSearch::within_limits(Angles a) const {
  a.yaw = wrap_angle(a.yaw);
  if (limits_.yaw_max - limits_.yaw_min < 2 * kOrientationPi - 1e-9) {
    const double middle = (limits_.yaw_min + limits_.yaw_max) / 2, half = (limits_.yaw_max - limits_.yaw_min) / 2;
    a.yaw = wrap_angle(middle + std::clamp(wrap_angle(a.yaw - middle), -half, half));
  }
  a.pitch = std::clamp(a.pitch, limits_.pitch_min, limits_.pitch_max);
  a.roll = std::clamp(a.roll, -limits_.roll_max, limits_.roll_max);
  return a;
}

Aim OrientationSearch::evaluate(const VisibleList& list, const OrientationCost& cost, Angles angles) const {
  Aim aim;
  aim.angles = within_limits(angles);
  const WindowPlanes window = window_.planes(aim.angles.yaw, aim.angles.pitch, aim.angles.roll);
  aim.value = list.sum(window) - cost(aim.angles, window);
  return aim;
}

Aim OrientationSearch::histogram(const VisibleList& list, const OrientationCost& cost, const Eigen::Vector3d& fallback) {
  if (list.size() == 0) {
    return evaluate(list, cost, {std::atan2(fallback.y(), fallback.x()), std::atan2(-fallback.z(), std::hypot(fallback.x(), fallback.y())), 0});
  }
  const PointArrays points = list.arrays();
  azimuth_.resize(static_cast<std::size_t>(points.count));
  elevation_.resize(static_cast<std::size_t>(points.count));
  point_angles(points, static_cast<float>(1 / kCell), azimuth_.data(), elevation_.data(), list.simd);
  constexpr int kStride = kAzimuths + kWrapped + 1;
  sums_.assign(static_cast<std::size_t>(kStride) * (kElevations + 1), 0.0);
  double range = 0;
  for (int i = 0; i < list.size(); ++i) {
    const int a = std::clamp(static_cast<int>(azimuth_[i]), 0, kAzimuths - 1);
    const int e = std::clamp(static_cast<int>(elevation_[i] + kElevations / 2.0f), 0, kElevations - 1);
    sums_[static_cast<std::size_t>(e + 1) * kStride + a + 1] += points.weight[i];
    range += std::sqrt(points.x[i] * points.x[i] + points.y[i] * points.y[i] + points.z[i] * points.z[i]);
  }
  range = std::clamp(range / list.size(), window_.depth_min, window_.depth_max);
  for (int e = 1; e <= kElevations; ++e) {
    double* row = &sums_[static_cast<std::size_t>(e) * kStride];
    for (int a = kAzimuths + 1; a < kStride; ++a) row[a] = row[a - kAzimuths];
    for (int a = 1; a < kStride; ++a) row[a] += row[a - 1];
    for (int a = 1; a < kStride; ++a) row[a] += row[a - kStride];
  }
  // The window that both eyes share at the points' distance.
  const double half_width = std::atan(std::max(window_.tan_horizontal - window_.baseline / 2 / range, 0.02));
  const int high = std::clamp(static_cast<int>(std::lround(2 * std::atan(window_.tan_vertical) / kCell)), 1, kElevations - 1);
  double most = -1;
  Angles best{std::atan2(fallback.y(), fallback.x()), 0, 0};
  const double yaw_middle = (limits_.yaw_min + limits_.yaw_max) / 2, yaw_half = (limits_.yaw_max - limits_.yaw_min) / 2 + kCell / 2;
  for (int e = 0; e + high <= kElevations; ++e) {
    const double elevation = (e + high / 2.0 - kElevations / 2.0) * kCell;
    if (elevation > -limits_.pitch_min + kCell / 2 || elevation < -limits_.pitch_max - kCell / 2) continue;
    const int wide = std::clamp(static_cast<int>(std::lround(2 * half_width / std::max(0.2, std::cos(elevation)) / kCell)), 1, kWrapped);
    const double *low = &sums_[static_cast<std::size_t>(e) * kStride], *top = low + static_cast<std::ptrdiff_t>(high) * kStride;
    for (int a = 0; a < kAzimuths; ++a) {
      const double sum = top[a + wide] - top[a] - low[a + wide] + low[a];
      if (sum > most) {
        const double yaw = wrap_angle((a + wide / 2.0) * kCell - kOrientationPi);
        if (std::abs(wrap_angle(yaw - yaw_middle)) > yaw_half) continue;
        most = sum;
        best = {yaw, -elevation, 0};
      }
    }
  }
  return evaluate(list, cost, best);
}

Aim OrientationSearch::compass(const VisibleList& list, const OrientationCost& cost, const Aim& start, double first, double last) const {
  Aim best = start;
  constexpr int kMoves = 6;  // at most, with each step
  for (double step = first; step >= last * 0.999; step /= 2) {
    bool moved = true;
    for (int move = 0; moved && move < kMoves; ++move) {
      moved = false;
      for (int axis = 0; axis < 3; ++axis) {
        if (axis == 2 && limits_.roll_max <= 0) continue;
        for (double sign : {1.0, -1.0}) {
          Angles a = best.angles;
          if (axis == 0) a.yaw += sign * step / std::max(0.4, std::cos(a.pitch));
          if (axis == 1) a.pitch += sign * step;
          if (axis == 2) a.roll += sign * step * 0.7;
          a = within_limits(a);
          if ((axis == 1 && a.pitch == best.angles.pitch) || (axis == 2 && a.roll == best.angles.roll)) continue;
          const Aim aim = evaluate(list, cost, a);
          if (aim.value > best.value) {
            best = aim;
            moved = true;
            break;
          }
        }
      }
    }
  }
  // A level view shows whole layers of the grid: often a peak too narrow for steps.
  if (best.angles.pitch != 0 && std::abs(best.angles.pitch) < kNearlyLevel) {
    const Aim aim = evaluate(list, cost, {best.angles.yaw, 0, best.angles.roll});
    if (aim.value > best.value) best = aim;
  }
  return best;
}

Aim OrientationSearch::kicks(const VisibleList& list, const OrientationCost& cost, const Aim& start, double last) const {
  Aim best = start;
  const int count = limits_.roll_max > 0 ? 6 : 4;
  for (int k = 0; k < count; ++k) {
    Angles a = start.angles;
    if (k < 4) {
      a.yaw += k % 2 == 0 ? -0.05 : 0.05;
      a.pitch += k / 2 == 0 ? -0.04 : 0.04;
    } else {
      a.roll = k % 2 == 0 ? -limits_.roll_max : limits_.roll_max;
    }
    const Aim aim = compass(list, cost, evaluate(list, cost, a), 2 * kOneDegree, last);
    if (aim.value > best.value) best = aim;
  }
  return best;
}

}  // namespace periplus::nbv
