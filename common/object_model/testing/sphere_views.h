// Ideal perceptions of a sphere before a far wall, by closed-form ray casting: what tests carve with.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "common/object_model/object_model.h"

namespace periplus::object_model::testing {

struct Sphere {
  Eigen::Vector3d center{0, 0, 1};
  double radius = 0.15;  // [m]
};

constexpr double kWallDepth = 6;  // along the optical axis [m]

inline DepthMap ideal_depth(const Sphere& sphere, const Pose& X_WC, const Pinhole& camera) {
  DepthMap map;
  map.camera = camera;
  map.X_WC = X_WC;
  map.depth = ImageF(camera.width, camera.height, 1, static_cast<float>(kWallDepth));
  const Eigen::Vector3d c = X_WC.inverse() * sphere.center;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d d = camera.back_project(u, v, 1);
      const double a = d.squaredNorm(), b = d.dot(c), q = b * b - a * (c.squaredNorm() - sphere.radius * sphere.radius);
      if (q >= 0) map.depth.at(u, v) = static_cast<float>((b - std::sqrt(q)) / a);
    }
  map.depth_minimum = map.depth;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du)
          if (u + du >= 0 && v + dv >= 0 && u + du < camera.width && v + dv < camera.height)
            map.depth_minimum.at(u, v) = std::min(map.depth_minimum.at(u, v), map.depth.at(u + du, v + dv));
  map.depth_sigma = ImageF(camera.width, camera.height, 1, 0.001f);
  return map;
}

// View `n` of `count` around the sphere, 1.1 m away, at alternating heights.
inline Perception ideal_view(const Sphere& sphere, int n, int count, int width = 320, int height = 240) {
  Perception p;
  p.view_id = "view-" + std::to_string(n);
  p.stamp_ns = 1000 + n;
  p.rig.camera = Pinhole::from_vertical_fov(width, height, 25 * std::numbers::pi / 180);
  p.rig.baseline = 0.144;
  const double angle = 2 * std::numbers::pi * n / count;
  const Eigen::Vector3d eye = sphere.center + Eigen::Vector3d(1.1 * std::cos(angle), 1.1 * std::sin(angle), n % 2 ? 0.5 : -0.4);
  p.X_WC = look_at(eye, sphere.center);
  p.depth.push_back(ideal_depth(sphere, p.X_WC, p.rig.camera));
  Pose X_WR = p.X_WC;
  X_WR.translation() = p.X_WC * Eigen::Vector3d(p.rig.baseline, 0, 0);
  p.depth.push_back(ideal_depth(sphere, X_WR, p.rig.camera));
  p.color = ImageU8(width, height, 3);
  for (std::size_t i = 0; i < p.color.data.size(); ++i) p.color.data[i] = static_cast<std::uint8_t>(i % 3 == 0 ? 200 : 40);
  p.silhouette_valid_share = 1;
  for (int k = 0; k < 5; ++k) {
    Feature f;
    f.u = static_cast<float>(width / 2 + k);
    f.v = static_cast<float>(height / 2);
    f.size = 4;
    f.normal_W = (eye - sphere.center).normalized();
    f.p_W = p.X_WC * p.rig.camera.back_project(f.u, f.v, p.depth[0].depth.at(width / 2 + k, height / 2));
    f.size_m = 0.01;
    f.descriptor.assign(128, static_cast<std::uint8_t>(k + n));
    p.features.push_back(f);
  }
  return p;
}

inline ObjectBox box_around(const Sphere& sphere, double side = 0.5) {
  ObjectBox box;
  box.X_WB.translation() = sphere.center;
  box.size = Eigen::Vector3d::Constant(side);
  return box;
}

// Least and greatest distance from the sphere's centre to a voxel.
inline std::pair<double, double> distance_range(const voxel::GridGeometry& g, const Eigen::Vector3i& v, const Sphere& sphere) {
  const Eigen::Vector3d c = (g.X_WG.inverse() * sphere.center) / g.voxel_size - v.cast<double>();
  const Eigen::Vector3d nearest = c.cwiseMax(0).cwiseMin(1) - c;
  const Eigen::Vector3d farthest = (c.array() < 0.5).select(1 - c.array(), -c.array());
  return {nearest.norm() * g.voxel_size, farthest.norm() * g.voxel_size};
}
inline bool touches(const voxel::GridGeometry& g, const Eigen::Vector3i& v, const Sphere& sphere) {
  const auto [least, most] = distance_range(g, v, sphere);
  return least <= sphere.radius && most >= sphere.radius;
}

template <class Visit>
void for_each_voxel(const voxel::GridGeometry& g, Visit&& visit) {
  for (int x = 0; x < g.size.x(); ++x)
    for (int y = 0; y < g.size.y(); ++y)
      for (int z = 0; z < g.size.z(); ++z) visit(Eigen::Vector3i(x, y, z));
}

}  // namespace periplus::object_model::testing
