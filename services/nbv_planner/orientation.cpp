#include "services/nbv_planner/orientation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace periplus::nbv {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kPixelsPerVoxel = 5;    // of the wide rendering, at kTypicalDistance
constexpr double kTypicalDistance = 1.2;  // [m]
constexpr double kGreatestFocal = 1300;   // keeps the image under 4096 px [px]
constexpr std::size_t kDirectionsTried = 48;
constexpr int kBestKept = 3;

}  // namespace

PairWindow PairWindow::of(const StereoRig& rig, const voxel::PairOptions& options) {
  return {rig.camera.width / 2.0 / rig.camera.fx, rig.camera.height / 2.0 / rig.camera.fy, rig.baseline, options.depth_min,
          options.depth_max};
}

int PairWindow::count(const Directions& points, double yaw, double pitch) const {
  const Eigen::Matrix3f R = look_along(Eigen::Vector3d::Zero(), yaw, pitch).linear().cast<float>();
  const Eigen::Vector3f right = R.col(0), down = R.col(1), forward = R.col(2);
  const float th = static_cast<float>(tan_horizontal), tv = static_cast<float>(tan_vertical);
  const float half = static_cast<float>(baseline / 2), near = static_cast<float>(depth_min), far = static_cast<float>(depth_max);
  int n = 0;
  for (const auto& p : points) {
    const float z = forward.dot(p);
    n += (z >= near) & (z <= far) & (std::abs(right.dot(p)) <= th * z - half) & (std::abs(down.dot(p)) <= tv * z);
  }
  return n;
}

Orientation choose_orientation(const PairWindow& window, const Directions& points, const Eigen::Vector3d& fallback,
                               double pitch_min, double pitch_max) {
  const auto towards = [&](const Eigen::Vector3d& d) {
    Orientation o;
    o.yaw = std::atan2(d.y(), d.x());
    o.pitch = std::clamp(std::atan2(-d.z(), std::hypot(d.x(), d.y())), pitch_min, pitch_max);
    o.count = window.count(points, o.yaw, o.pitch);
    return o;
  };
  if (points.empty()) return towards(fallback);
  std::vector<Orientation> tried;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p.cast<double>();
  tried.push_back(towards(mean / static_cast<double>(points.size())));
  // Evenly over the list, without a stride that could fall in step with its order.
  for (std::size_t k = 0; k < std::min(kDirectionsTried, points.size()); ++k) {
    const double share = std::fmod((static_cast<double>(k) + 0.5) * (std::numbers::phi - 1), 1.0);
    tried.push_back(towards(points[static_cast<std::size_t>(share * static_cast<double>(points.size()))].cast<double>()));
  }
  std::stable_sort(tried.begin(), tried.end(), [](const auto& a, const auto& b) { return a.count > b.count; });
  Orientation best = tried[0];
  for (int i = 0; i < kBestKept && i < static_cast<int>(tried.size()); ++i) {
    Orientation at = tried[i];
    for (double step = 4 * kDegree; step > 0.4 * kDegree;) {
      bool better = false;
      for (int k = 0; k < 4; ++k) {
        Orientation o = at;
        o.yaw += k == 0 ? step : k == 1 ? -step : 0;
        o.pitch = std::clamp(o.pitch + (k == 2 ? step : k == 3 ? -step : 0), pitch_min, pitch_max);
        o.count = window.count(points, o.yaw, o.pitch);
        if (o.count > at.count) {
          at = o;
          better = true;
        }
      }
      if (!better) step /= 2;
    }
    if (at.count > best.count) best = at;
  }
  best.yaw = wrap_angle(best.yaw);
  return best;
}

Pose left_eye(const Eigen::Vector3d& p_W, double yaw, double pitch, double baseline) {
  return look_along(p_W, yaw, pitch) * Pose(Eigen::Translation3d(-baseline / 2, 0, 0));
}

Sample look_around(const Evaluator& evaluator, const Eigen::Vector3d& p_W, voxel::VisibilityWorkspace& workspace) {
  const Situation& s = evaluator.situation();
  const voxel::VisibilityScene& scene = evaluator.visibility();
  const voxel::GridGeometry& g = scene.geometry();
  const Eigen::Vector3d size = g.size.cast<double>() * g.voxel_size;
  const Eigen::Vector3d middle = g.X_WG * (size / 2);
  const Pose X_WP = look_at(p_W, middle);
  // The window that the grid's box fills, cut at 57 and 50 degrees from the axis.
  const double limit_u = std::tan(57 * kDegree), limit_v = std::tan(50 * kDegree);
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d corner = Eigen::Vector3d(c & 1, c >> 1 & 1, c >> 2 & 1).cwiseProduct(size);
    const Eigen::Vector3d q = X_WP.inverse() * (g.X_WG * corner);
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
  const double focal = std::min({s.rig.camera.fx, kPixelsPerVoxel * kTypicalDistance / g.voxel_size, kGreatestFocal});
  u0 = std::max(u0, -limit_u);
  u1 = std::min(u1, limit_u);
  v0 = std::max(v0, -limit_v);
  v1 = std::min(v1, limit_v);
  Pinhole wide;
  wide.fx = wide.fy = focal;
  wide.cx = 1 - u0 * focal;
  wide.cy = 1 - v0 * focal;
  wide.width = static_cast<int>(wide.cx + u1 * focal) + 2;
  wide.height = static_cast<int>(wide.cy + v1 * focal) + 2;
  scene.evaluate(X_WP, wide, workspace, workspace.left);

  const double scale = focal / s.rig.camera.fx;
  const double threshold = evaluator.settings().pair.more_than_pixels * scale * scale;
  Directions points;
  points.reserve(workspace.left.unknown.size());
  for (const voxel::VoxelPixels& v : workspace.left.unknown) {
    if (v.pixels > threshold) points.push_back((g.center_world(scene.voxel(v.voxel)) - p_W).cast<float>());
  }
  const PairWindow window = PairWindow::of(s.rig, evaluator.settings().pair);
  const Orientation o = choose_orientation(window, points, middle - p_W, s.limits.pitch_min, s.limits.pitch_max);
  Sample sample;
  sample.X_WC = left_eye(p_W, o.yaw, o.pitch, s.rig.baseline);
  sample.voxels = o.count;
  if (evaluator.landmark_term()) {
    const Eigen::Vector3d view = sample.X_WC.linear().col(2);
    for (const voxel::VoxelPixels& v : workspace.left.watched) {
      const Evaluator::Mark* m = evaluator.mark(v.voxel);
      if (m == nullptr) continue;
      const Directions one{(g.center_world(scene.voxel(v.voxel)) - p_W).cast<float>()};
      if (window.count(one, o.yaw, o.pitch) == 0) continue;
      sample.landmarks += evaluator.landmark_visibility(v.pixels / (scale * scale), m->least_pixels, view, m->normal);
    }
  }
  return sample;
}

}  // namespace periplus::nbv
