// Distances by the shapes' own signed distance functions. Those of convex shapes are convex, so along a capsule's
// segment the least one is found by bisection on the sign of the slope, inside and outside alike (FCL's signed
// distance aborts on some touching configurations). A mesh answers for itself (mesh_solid.h). Overlap of boxes with
// shapes is FCL's.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/core/error.h"
#include "common/scene/mesh_solid.h"
#include "common/scene/scene.h"

namespace periplus::scene {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNoSlope = 1e-12;

// Signed distance of a point in the shape's frame, and the unit outward direction in which it grows.
double box_distance(const Vector3d& half, const Vector3d& p, Vector3d& gradient) {
  const Vector3d q = p.cwiseAbs() - half;
  const Vector3d sign(p.x() < 0 ? -1 : 1, p.y() < 0 ? -1 : 1, p.z() < 0 ? -1 : 1);
  const Vector3d outside = q.cwiseMax(0);
  const double d = outside.norm();
  if (d > 0) {
    gradient = outside.cwiseProduct(sign) / d;
    return d;
  }
  int axis = 0;
  const double depth = q.maxCoeff(&axis);
  gradient = Vector3d::Zero();
  gradient[axis] = sign[axis];
  return depth;
}

double sphere_distance(double radius, const Vector3d& p, Vector3d& gradient) {
  const double d = p.norm();
  gradient = d > 0 ? Vector3d(p / d) : Vector3d::UnitZ();
  return d - radius;
}

double cylinder_distance(double radius, double half_height, const Vector3d& p, Vector3d& gradient) {
  const double r = p.head<2>().norm();
  const Vector3d radial = r > 0 ? Vector3d(p.x() / r, p.y() / r, 0) : Vector3d::UnitX();
  const Vector3d axial(0, 0, p.z() < 0 ? -1 : 1);
  const double side = r - radius, cap = std::abs(p.z()) - half_height;
  if (side > 0 && cap > 0) {
    const double d = std::hypot(side, cap);
    gradient = (side * radial + cap * axial) / d;
    return d;
  }
  gradient = side > cap ? radial : axial;
  return std::max(side, cap);
}

double shape_distance(const Solid& s, const Vector3d& p, Vector3d& gradient) {
  switch (s.shape) {
    case Shape::box: return box_distance(s.size / 2, p, gradient);
    case Shape::sphere: return sphere_distance(s.size.x() / 2, p, gradient);
    case Shape::mesh: return s.mesh->distance(p, gradient);
    case Shape::cylinder: break;
  }
  return cylinder_distance(s.size.x() / 2, s.size.z() / 2, p, gradient);
}

// Of a mesh for overlaps, with its triangles in a tree of oriented boxes.
std::shared_ptr<fcl::CollisionGeometryd> fcl_mesh(const mesh::TriangleMesh& m) {
  auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  model->beginModel(static_cast<int>(m.triangles.size()), static_cast<int>(m.vertices.size()));
  for (const Eigen::Vector3i& t : m.triangles) {
    const auto corner = [&](int k) -> const Vector3d& { return m.vertices[static_cast<std::size_t>(t[k])]; };
    model->addTriangle(corner(0), corner(1), corner(2));
  }
  model->endModel();
  return model;
}

// Where the segment p + t d, t in 0..1, enters lower <= x <= upper in one coordinate; shrinks [t0, t1].
bool clip(double p, double d, double lower, double upper, double& t0, double& t1) {
  if (std::abs(d) < 1e-15) return p >= lower && p <= upper;
  double a = (lower - p) / d, b = (upper - p) / d;
  if (a > b) std::swap(a, b);
  t0 = std::max(t0, a);
  t1 = std::min(t1, b);
  return t0 <= t1;
}

// As clip, for a x x + 2 b x + c <= 0 (a sphere, or an infinite cylinder).
bool clip_quadratic(double a, double b, double c, double& t0, double& t1) {
  if (a < 1e-15) return c <= 0;
  const double root = b * b - a * c;
  if (root < 0) return false;
  t0 = std::max(t0, (-b - std::sqrt(root)) / a);
  t1 = std::min(t1, (-b + std::sqrt(root)) / a);
  return t0 <= t1;
}

std::optional<double> segment_hit(const Solid& s, const Vector3d& p, const Vector3d& d) {
  if (s.shape == Shape::mesh) return s.mesh->first_hit(p, d);
  const Vector3d half = s.size / 2;
  double t0 = 0, t1 = 1;
  bool hit = false;
  switch (s.shape) {
    case Shape::box:
      hit = clip(p.x(), d.x(), -half.x(), half.x(), t0, t1) && clip(p.y(), d.y(), -half.y(), half.y(), t0, t1) &&
            clip(p.z(), d.z(), -half.z(), half.z(), t0, t1);
      break;
    case Shape::sphere:
      hit = clip_quadratic(d.squaredNorm(), p.dot(d), p.squaredNorm() - half.x() * half.x(), t0, t1);
      break;
    case Shape::cylinder: {
      const Vector2d p2 = p.head<2>(), d2 = d.head<2>();
      hit = clip_quadratic(d2.squaredNorm(), p2.dot(d2), p2.squaredNorm() - half.x() * half.x(), t0, t1) &&
            clip(p.z(), d.z(), -half.z(), half.z(), t0, t1);
      break;
    }
    case Shape::mesh: break;
  }
  return hit ? std::optional<double>(t0) : std::nullopt;
}

}  // namespace

struct CollisionWorld::Impl {
  struct Entry {
    Solid solid;
    Pose X_SW;
    std::shared_ptr<fcl::CollisionGeometryd> geometry;
  };
  std::vector<Entry> entries;
  Vector3d room_half;

  // A half-space: x in it where normal . x > offset. -1 floor, -2 +x, -3 -x, -4 +y, -5 -y.
  struct Plane {
    Vector3d outward;  // from the wall into the room
    double offset;     // distance of p: outward . p + offset
  };
  std::array<Plane, 5> planes;

  double distance(int index, const Vector3d& p_W, Vector3d& gradient_W) const {
    if (index < 0) {
      const Plane& plane = planes[static_cast<std::size_t>(-1 - index)];
      gradient_W = plane.outward;
      return plane.outward.dot(p_W) + plane.offset;
    }
    const Entry& e = entries[static_cast<std::size_t>(index)];
    Vector3d gradient_S;
    const double d = shape_distance(e.solid, e.X_SW * p_W, gradient_S);
    gradient_W = e.solid.X_WS.linear() * gradient_S;
    return d;
  }

  Closest capsule(int index, const Vector3d& a, const Vector3d& b, double radius) const {
    const Vector3d way = b - a;
    Vector3d gradient;
    double low = 0, high = 1, t = 0;
    if (index >= 0 && entries[static_cast<std::size_t>(index)].solid.mesh) {
      const Entry& e = entries[static_cast<std::size_t>(index)];
      const double nearest = e.solid.mesh->segment_distance(e.X_SW * a, e.X_SW * b, t, gradient);
      return closest(index, a + t * way, nearest, e.solid.X_WS.linear() * gradient, radius);
    }
    double d = distance(index, a, gradient);
    if (gradient.dot(way) < 0) {
      const double at_end = distance(index, b, gradient);
      if (gradient.dot(way) <= 0) {
        t = 1;
        d = at_end;
      } else {
        for (int i = 0; i < 40; ++i) {
          t = (low + high) / 2;
          d = distance(index, a + t * way, gradient);
          const double slope = gradient.dot(way);
          if (std::abs(slope) < kNoSlope) break;
          (slope > 0 ? high : low) = t;
        }
      }
    }
    const Vector3d p = a + t * way;
    d = distance(index, p, gradient);
    return closest(index, p, d, gradient, radius);
  }

  // Of a ball about p, whose middle is `d` away.
  static Closest closest(int index, const Vector3d& p, double d, const Vector3d& gradient, double radius) {
    Closest c;
    c.distance = d - radius;
    c.on_shape = p - radius * gradient;
    c.on_solid = p - d * gradient;
    c.solid = index;
    return c;
  }

  bool overlaps(const Entry& e, const Pose& X_WB, const Vector3d& size, const fcl::CollisionObjectd& box) const {
    Vector3d gradient;
    const double d = shape_distance(e.solid, e.X_SW * X_WB.translation(), gradient);
    if (d > size.norm() / 2) return false;       // beyond the circumscribed sphere
    if (d <= size.minCoeff() / 2) return true;   // within the inscribed sphere
    const fcl::CollisionObjectd other(e.geometry, fcl::Transform3d(e.solid.X_WS));
    fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    return fcl::collide(&box, &other, request, result) > 0;
  }

  bool touches_solid(const Pose& X_WB, const Vector3d& size) const {
    const fcl::CollisionObjectd box(std::make_shared<fcl::Boxd>(size), fcl::Transform3d(X_WB));
    return std::any_of(entries.begin(), entries.end(), [&](const Entry& e) { return overlaps(e, X_WB, size, box); });
  }
};

CollisionWorld::CollisionWorld(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  impl_->room_half = scene.room.size / 2;
  const Vector3d& h = impl_->room_half;
  impl_->planes = {{{Vector3d::UnitZ(), 0},
                    {-Vector3d::UnitX(), h.x()},
                    {Vector3d::UnitX(), h.x()},
                    {-Vector3d::UnitY(), h.y()},
                    {Vector3d::UnitY(), h.y()}}};
  for (const Solid& s : scene.solids) {
    Impl::Entry e{s, s.X_WS.inverse(), nullptr};
    switch (s.shape) {
      case Shape::box: e.geometry = std::make_shared<fcl::Boxd>(s.size); break;
      case Shape::cylinder: e.geometry = std::make_shared<fcl::Cylinderd>(s.size.x() / 2, s.size.z()); break;
      case Shape::sphere: e.geometry = std::make_shared<fcl::Sphered>(s.size.x() / 2); break;
      case Shape::mesh:
        require(s.mesh != nullptr, ErrorCode::bad_input, "solid '" + s.name + "' is a mesh without its triangles");
        e.geometry = fcl_mesh(s.mesh->mesh());
        break;
    }
    impl_->entries.push_back(std::move(e));
  }
}

CollisionWorld::~CollisionWorld() = default;
CollisionWorld::CollisionWorld(CollisionWorld&&) noexcept = default;

Closest CollisionWorld::capsule_distance(const Vector3d& a, const Vector3d& b, double radius, double range) const {
  const Vector3d middle = (a + b) / 2;
  const double reach = (b - a).norm() / 2 + radius;
  Closest best;
  best.distance = range;
  best.on_shape = best.on_solid = middle;
  Vector3d gradient;
  for (int i = -5; i < static_cast<int>(impl_->entries.size()); ++i) {
    if (i == -1) continue;
    if (impl_->distance(i, middle, gradient) - reach >= best.distance) continue;
    const Closest c = impl_->capsule(i, a, b, radius);
    if (c.distance < best.distance) best = c;
  }
  return best;
}

Closest CollisionWorld::capsule_distance_to(int solid, const Vector3d& a, const Vector3d& b, double radius) const {
  require(solid >= -5 && solid < static_cast<int>(impl_->entries.size()), ErrorCode::unknown_id,
          "no solid number " + std::to_string(solid) + " in this scene");
  return impl_->capsule(solid, a, b, radius);
}

bool CollisionWorld::box_collides(const Pose& X_WB, const Vector3d& size) const {
  const Vector3d reach = X_WB.linear().cwiseAbs() * size / 2;
  const Vector3d& c = X_WB.translation();
  if (std::abs(c.x()) + reach.x() >= impl_->room_half.x() || std::abs(c.y()) + reach.y() >= impl_->room_half.y()) return true;
  return impl_->touches_solid(X_WB, size);
}

bool CollisionWorld::contains(const Vector3d& p, double margin) const {
  Vector3d gradient;
  for (int i = 0; i < static_cast<int>(impl_->entries.size()); ++i)
    if (impl_->distance(i, p, gradient) <= margin) return true;
  return false;
}

bool CollisionWorld::contains_or_floor(const Vector3d& p, double margin) const { return p.z() <= margin || contains(p, margin); }

bool CollisionWorld::box_touches_solid(const Pose& X_WB, const Vector3d& size) const {
  return impl_->touches_solid(X_WB, size);
}

std::optional<double> CollisionWorld::first_hit(const Vector3d& p, const Vector3d& q) const {
  std::optional<double> first;
  for (const auto& e : impl_->entries) {
    const auto t = segment_hit(e.solid, e.X_SW * p, e.X_SW.linear() * (q - p));
    if (t && (!first || *t < *first)) first = t;
  }
  return first;
}

}  // namespace periplus::scene
