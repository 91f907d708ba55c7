#include "integration-tests/evaluation/obstacles.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/scene/mesh_solid.h"

namespace periplus::evaluation {

namespace {

constexpr double kContact = 1e-4;  // [m]
constexpr int kMostProjections = 2000;

using Eigen::Vector3d;

// Nearest point of a solid, in its frame.
Vector3d nearest_in_solid(const scene::Solid& solid, const Vector3d& p) {
  const double radius = solid.size.x() / 2;
  switch (solid.shape) {
    case scene::Shape::box: return p.cwiseMax(-solid.size / 2).cwiseMin(solid.size / 2);
    case scene::Shape::sphere: return p.norm() <= radius ? p : Vector3d(p * (radius / p.norm()));
    case scene::Shape::mesh: {
      Vector3d outwards;
      const double d = solid.mesh->distance(p, outwards);
      return d <= 0 ? p : Vector3d(p - d * outwards);
    }
    case scene::Shape::cylinder: break;
  }
  const double across = std::hypot(p.x(), p.y()), shrink = across <= radius ? 1 : radius / across;
  return {p.x() * shrink, p.y() * shrink, std::clamp(p.z(), -solid.size.z() / 2, solid.size.z() / 2)};
}

// Share of the way [enter, leave] in which a segment is inside; empty if enter > leave.
struct Inside {
  double enter = 0, leave = 1;
  // Between -half and half of one coordinate.
  void slab(double p, double d, double half) {
    if (d == 0) {
      if (std::abs(p) > half) leave = -1;
      return;
    }
    const double a = (-half - p) / d, b = (half - p) / d;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  // Within `radius` of the origin, of as many coordinates as there are.
  template <class Vector>
  void round(const Vector& p, const Vector& d, double radius) {
    const double a = d.squaredNorm(), b = p.dot(d), c = p.squaredNorm() - radius * radius;
    if (a == 0) {
      if (c > 0) leave = -1;
      return;
    }
    const double discriminant = b * b - a * c;
    if (discriminant < 0) {
      leave = -1;
      return;
    }
    enter = std::max(enter, (-b - std::sqrt(discriminant)) / a);
    leave = std::min(leave, (-b + std::sqrt(discriminant)) / a);
  }
};

bool meets(const scene::Solid& solid, const Vector3d& p_W, const Vector3d& q_W) {
  const Pose X_SW = solid.X_WS.inverse();
  const Vector3d p = X_SW * p_W, d = X_SW.linear() * (q_W - p_W);
  if (solid.shape == scene::Shape::mesh) return solid.mesh->first_hit(p, d).has_value();
  Inside inside;
  switch (solid.shape) {
    case scene::Shape::box:
      for (int i = 0; i < 3; ++i) inside.slab(p[i], d[i], solid.size[i] / 2);
      break;
    case scene::Shape::sphere: inside.round(p, d, solid.size.x() / 2); break;
    case scene::Shape::cylinder:
      inside.round(Eigen::Vector2d(p.head<2>()), Eigen::Vector2d(d.head<2>()), solid.size.x() / 2);
      inside.slab(p.z(), d.z(), solid.size.z() / 2);
      break;
    case scene::Shape::mesh: break;
  }
  return inside.enter <= inside.leave;
}

// What a box leaves of each triangle when it is cut at the box's six planes (Sutherland and Hodgman 1974).
bool touches_mesh(const scene::Solid& solid, const Pose& X_WB, const Vector3d& size) {
  const Pose X_BS = X_WB.inverse() * solid.X_WS;
  const mesh::TriangleMesh& mesh = solid.mesh->mesh();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    std::vector<Vector3d> polygon;
    for (int k = 0; k < 3; ++k) polygon.push_back(X_BS * mesh.vertices[static_cast<std::size_t>(t[k])]);
    for (int plane = 0; plane < 6 && !polygon.empty(); ++plane) {
      const int axis = plane / 2;
      const auto within = [&](const Vector3d& p) { return size[axis] / 2 + kContact / 2 - (plane % 2 == 0 ? p[axis] : -p[axis]); };
      std::vector<Vector3d> kept;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vector3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double a = within(p), b = within(q);
        if (a >= 0) kept.push_back(p);
        if ((a >= 0) != (b >= 0)) kept.push_back(p + (q - p) * (a / (a - b)));
      }
      polygon = kept;
    }
    if (!polygon.empty()) return true;
  }
  Vector3d outwards;
  return solid.mesh->distance(X_BS.inverse().translation(), outwards) < 0;  // the box is in it as a whole
}

// Going to and fro between the nearest points of two convex bodies leads to their nearest pair (Cheney and Goldstein 1959).
bool touches(const scene::Solid& solid, const Pose& X_WB, const Vector3d& size) {
  if (solid.shape == scene::Shape::mesh) return touches_mesh(solid, X_WB, size);
  const Pose X_BS = X_WB.inverse() * solid.X_WS, X_SB = X_BS.inverse();
  Vector3d in_box = Vector3d::Zero();
  for (int i = 0; i < kMostProjections; ++i) {
    const Vector3d in_solid = X_BS * nearest_in_solid(solid, X_SB * in_box);
    const Vector3d next = in_solid.cwiseMax(-size / 2).cwiseMin(size / 2);
    if ((next - in_solid).norm() < kContact) return true;
    if ((next - in_box).norm() < 1e-9) return false;
    in_box = next;
  }
  return false;
}

}  // namespace

bool Obstacles::block(const Vector3d& p, const Vector3d& q) const {
  return std::any_of(solids_.begin(), solids_.end(), [&](const scene::Solid& solid) { return meets(solid, p, q); });
}

bool Obstacles::touch_box(const Pose& X_WB, const Vector3d& size) const {
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d p = X_WB * Vector3d((corner & 1 ? 0.5 : -0.5) * size.x(), (corner & 2 ? 0.5 : -0.5) * size.y(), (corner & 4 ? 0.5 : -0.5) * size.z());
    if (std::abs(p.x()) > room_.x() / 2 || std::abs(p.y()) > room_.y() / 2) return true;
  }
  return std::any_of(solids_.begin(), solids_.end(), [&](const scene::Solid& solid) { return touches(solid, X_WB, size); });
}

bool Obstacles::touch_ball(const Vector3d& center, double radius) const {
  if (std::abs(center.x()) + radius > room_.x() / 2 || std::abs(center.y()) + radius > room_.y() / 2) return true;
  return std::any_of(solids_.begin(), solids_.end(), [&](const scene::Solid& solid) {
    const Vector3d p_S = solid.X_WS.inverse() * center;
    return (nearest_in_solid(solid, p_S) - p_S).norm() < radius + kContact;
  });
}

}  // namespace periplus::evaluation
