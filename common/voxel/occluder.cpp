#include "common/voxel/occluder.h"

#include <cmath>
#include <numbers>

#include "common/core/error.h"

namespace periplus::voxel {

Occluder Occluder::box(const Pose& X_WS, const Eigen::Vector3d& size) {
  Occluder o;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d corner(c & 1, c >> 1 & 1, c >> 2 & 1);
    o.points_W.push_back(X_WS * (corner.array() - 0.5).matrix().cwiseProduct(size).eval());
  }
  return o;
}

Occluder Occluder::cylinder(const Pose& X_WS, double diameter, double height) {
  constexpr int kSides = 64;
  constexpr double kStep = 2 * std::numbers::pi / kSides;
  const double radius = diameter / 2 * std::sqrt(kStep / std::sin(kStep));
  Occluder o;
  for (int i = 0; i < kSides; ++i) {
    for (double z : {-height / 2, height / 2}) {
      o.points_W.push_back(X_WS * Eigen::Vector3d(radius * std::cos(i * kStep), radius * std::sin(i * kStep), z));
    }
  }
  return o;
}

Occluder Occluder::sphere(const Eigen::Vector3d& p_WS, double diameter) {
  constexpr int kRings = 16, kSides = 32;
  const double radius = diameter / 2 * 1.0048;  // half way between inscribed and circumscribed
  Occluder o;
  for (int i = 0; i <= kRings; ++i) {
    const double polar = std::numbers::pi * i / kRings;
    const int sides = i == 0 || i == kRings ? 1 : kSides;
    for (int j = 0; j < sides; ++j) {
      const double angle = 2 * std::numbers::pi * j / kSides;
      o.points_W.push_back(p_WS + radius * Eigen::Vector3d(std::sin(polar) * std::cos(angle),
                                                           std::sin(polar) * std::sin(angle), std::cos(polar)));
    }
  }
  return o;
}

std::vector<Occluder> Occluder::mesh(const std::vector<Eigen::Vector3d>& vertices_W, const std::vector<Eigen::Vector3i>& triangles) {
  std::vector<Occluder> out;
  out.reserve(triangles.size());
  for (const Eigen::Vector3i& t : triangles) {
    require((t.array() >= 0).all() && (t.array() < static_cast<int>(vertices_W.size())).all(), ErrorCode::bad_input, "a triangle names a vertex that the mesh does not have");
    out.push_back({{vertices_W[static_cast<std::size_t>(t[0])], vertices_W[static_cast<std::size_t>(t[1])], vertices_W[static_cast<std::size_t>(t[2])]}});
  }
  return out;
}

}  // namespace periplus::voxel
