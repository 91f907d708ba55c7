#include "integration-tests/nbv_benchmark/surface_coverage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"

namespace periplus::nbv_benchmark {
namespace {

constexpr double kGrazing = 75 * std::numbers::pi / 180;
constexpr double kOnSurface = 1e-4;  // a hit this near to the sample is the sample's own surface [m]

}  // namespace

void add_covered(const std::vector<mesh::SurfaceSample>& samples, const ImageF& depth, const Pinhole& camera, const Pose& X_SC,
                 double distance, Mask& covered) {
  require(depth.width == camera.width && depth.height == camera.height && covered.size() == samples.size(), ErrorCode::bad_size,
          "depth map, camera and samples must fit each other");
  const Pose X_CS = X_SC.inverse();
  const double squared = distance * distance;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (covered.test(i)) continue;
    const Eigen::Vector3d p = X_CS * samples[i].point;
    if (p.z() <= 2 * distance) continue;  // no sensor measures there
    // A point within `distance` projects no further away than this: |dx z - x dz| <= distance |(x, z)|.
    const double scale = distance / (p.z() * (p.z() - distance));
    const Eigen::Vector2d c = camera.project(p);
    const double ru = camera.fx * scale * std::hypot(p.x(), p.z()), rv = camera.fy * scale * std::hypot(p.y(), p.z());
    if (!(c.x() + ru >= 0 && c.y() + rv >= 0 && c.x() - ru <= camera.width - 1 && c.y() - rv <= camera.height - 1)) continue;
    const int u0 = std::max(0, static_cast<int>(std::ceil(c.x() - ru))), u1 = std::min(camera.width - 1, static_cast<int>(std::floor(c.x() + ru)));
    const int v0 = std::max(0, static_cast<int>(std::ceil(c.y() - rv))), v1 = std::min(camera.height - 1, static_cast<int>(std::floor(c.y() + rv)));
    const auto near = [&](int u, int v) {
      const double z = depth.at(u, v);
      if (!(z > 0) || std::abs(z - p.z()) > distance) return false;
      return (camera.back_project(u, v, z) - p).squaredNorm() <= squared;
    };
    // Nearly always the pixel that shows it, if any does.
    const int mu = std::clamp(static_cast<int>(std::lround(c.x())), u0, std::max(u0, u1));
    const int mv = std::clamp(static_cast<int>(std::lround(c.y())), v0, std::max(v0, v1));
    bool found = u0 <= u1 && v0 <= v1 && near(mu, mv);
    for (int v = v0; v <= v1 && !found; ++v)
      for (int u = u0; u <= u1 && !found; ++u) found = near(u, v);
    if (found) covered.set(i);
  }
}

void add_visible(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& normals,
                 const std::vector<const mesh::TriangleTree*>& occluders, const Viewer& viewer, Mask& visible) {
  const double least_cosine = std::cos(kGrazing);
  const Pinhole& camera = viewer.camera;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (visible.test(i)) continue;
    bool seen = true;
    for (const Pose& X : viewer.X_SC) {
      const Eigen::Vector3d p = X.inverse() * points[i];
      if (p.z() <= 0) seen = false;
      if (!seen) break;
      const Eigen::Vector2d c = camera.project(p);
      const Eigen::Vector3d ray = points[i] - X.translation();
      const double length = ray.norm();
      if (c.x() < -0.5 || c.y() < -0.5 || c.x() > camera.width - 0.5 || c.y() > camera.height - 0.5 ||
          std::abs(ray.dot(normals[i])) < least_cosine * length)
        seen = false;
      if (!seen) break;
    }
    for (std::size_t e = 0; e < viewer.X_SC.size() && seen; ++e) {
      const Eigen::Vector3d eye = viewer.X_SC[e].translation(), ray = points[i] - eye;
      for (const mesh::TriangleTree* tree : occluders)
        if (tree->ray(eye, ray, 1 - kOnSurface / ray.norm())) seen = false;
    }
    if (seen) visible.set(i);
  }
}

}  // namespace periplus::nbv_benchmark
