#include "common/mesh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/core/error.h"

namespace periplus::mesh {
namespace {

using Eigen::Vector3d;

constexpr int kLeaf = 4;
using Corners = std::array<Vector3d, 3>;

// C. Ericson, Real-Time Collision Detection, 5.1.5.
Vector3d closest_on_triangle(const Corners& c, const Vector3d& p) {
  const auto& [a, b, d] = c;
  const Vector3d ab = b - a, ac = d - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  const Vector3d cp = p - d;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return d;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (d - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double denominator = 1 / (va + vb + vc);
  return a + ab * (vb * denominator) + ac * (vc * denominator);
}

// Nearest points p + s d and q + t e of two segments, s and t in 0..1 (Ericson, 5.1.9).
std::pair<double, double> closest_of_segments(const Vector3d& p, const Vector3d& d, const Vector3d& q, const Vector3d& e) {
  const Vector3d r = p - q;
  const double a = d.squaredNorm(), c = e.squaredNorm(), f = e.dot(r), g = d.dot(r), b = d.dot(e);
  if (a == 0 && c == 0) return {0, 0};
  if (a == 0) return {0, std::clamp(f / c, 0.0, 1.0)};
  if (c == 0) return {std::clamp(-g / a, 0.0, 1.0), 0};
  const double denominator = a * c - b * b;
  double s = denominator > 1e-14 * a * c ? std::clamp((b * f - g * c) / denominator, 0.0, 1.0) : 0;
  double t = (b * s + f) / c;
  if (t < 0) {
    t = 0;
    s = std::clamp(-g / a, 0.0, 1.0);
  } else if (t > 1) {
    t = 1;
    s = std::clamp((b - g) / a, 0.0, 1.0);
  }
  return {s, t};
}

// T. Moeller, B. Trumbore 1997.
std::optional<double> ray_triangle(const Corners& c, const Vector3d& o, const Vector3d& d) {
  const Vector3d e1 = c[1] - c[0], e2 = c[2] - c[0], h = d.cross(e2);
  const double det = e1.dot(h);
  if (det == 0) return std::nullopt;
  const Vector3d s = o - c[0];
  const double u = s.dot(h) / det;
  if (u < 0 || u > 1) return std::nullopt;
  const Vector3d q = s.cross(e1);
  const double v = d.dot(q) / det;
  if (v < 0 || u + v > 1) return std::nullopt;
  const double t = e2.dot(q) / det;
  return t >= 0 ? std::optional<double>(t) : std::nullopt;
}

struct Node {
  Vector3d lower, upper;
  int first = 0, count = 0;  // leaf: triangles; inner: count 0, first = right child, the left one follows directly
};

double distance_squared(const Node& n, const Vector3d& p) {
  return (n.lower - p).cwiseMax(p - n.upper).cwiseMax(0).squaredNorm();
}

bool ray_box(const Node& n, const Vector3d& o, const Vector3d& inverse, double t_max) {
  double low = 0, high = t_max;
  for (int k = 0; k < 3; ++k) {
    const double a = (n.lower[k] - o[k]) * inverse[k], b = (n.upper[k] - o[k]) * inverse[k];
    // 0 times infinity: the ray runs along a face of the box, and so within it as far as this axis is concerned.
    if (std::isnan(a) || std::isnan(b)) continue;
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }
  return low <= high * (1 + 1e-12);
}

}  // namespace

struct TriangleTree::Impl {
  std::vector<Corners> corners;
  std::vector<int> order;
  std::vector<Node> nodes;

  // Calls for the triangles of all leaves that may be nearer than `nearest()`, which may fall meanwhile; the nearer half of a node first.
  template <class Bound, class Nearest, class Call>
  void visit(const Bound& bound, const Nearest& nearest, const Call& call) const {
    std::array<int, 128> stack;  // the tree is balanced: 64 levels are beyond any memory
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const int at = stack[--top];
      const Node& n = nodes[static_cast<std::size_t>(at)];
      if (bound(n) >= nearest()) continue;
      if (n.count == 0) {
        int near = at + 1, far = n.first;
        if (bound(nodes[static_cast<std::size_t>(far)]) < bound(nodes[static_cast<std::size_t>(near)])) std::swap(near, far);
        stack[top++] = far;
        stack[top++] = near;
        continue;
      }
      for (int i = n.first; i < n.first + n.count; ++i) {
        const int triangle = order[static_cast<std::size_t>(i)];
        call(triangle, corners[static_cast<std::size_t>(triangle)]);
      }
    }
  }

  void build(int first, int count) {
    const auto at = nodes.size();
    nodes.emplace_back();
    Node node;
    node.lower = Vector3d::Constant(std::numeric_limits<double>::infinity());
    node.upper = -node.lower;
    Vector3d centre_low = node.lower, centre_high = node.upper;
    for (int i = first; i < first + count; ++i) {
      const Corners& c = corners[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])];
      for (const Vector3d& p : c) {
        node.lower = node.lower.cwiseMin(p);
        node.upper = node.upper.cwiseMax(p);
      }
      const Vector3d m = c[0] + c[1] + c[2];
      centre_low = centre_low.cwiseMin(m);
      centre_high = centre_high.cwiseMax(m);
    }
    if (count <= kLeaf) {
      node.first = first;
      node.count = count;
      nodes[at] = node;
      return;
    }
    int axis = 0;
    (centre_high - centre_low).maxCoeff(&axis);
    const auto begin = order.begin() + first;
    const int half = count / 2;
    std::nth_element(begin, begin + half, begin + count, [&](int a, int b) {
      const auto middle = [&](int i) {
        const Corners& c = corners[static_cast<std::size_t>(i)];
        return c[0][axis] + c[1][axis] + c[2][axis];
      };
      const double ma = middle(a), mb = middle(b);
      return ma < mb || (ma == mb && a < b);
    });
    build(first, half);
    node.first = static_cast<int>(nodes.size());
    build(first + half, count - half);
    nodes[at] = node;
  }
};

TriangleTree::TriangleTree(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>()) {
  mesh.check();
  require(!mesh.empty(), ErrorCode::bad_input, "mesh: there are no triangles to search in");
  for (const Eigen::Vector3i& t : mesh.triangles)
    impl_->corners.push_back({mesh.vertices[static_cast<std::size_t>(t[0])], mesh.vertices[static_cast<std::size_t>(t[1])],
                              mesh.vertices[static_cast<std::size_t>(t[2])]});
  impl_->order.resize(impl_->corners.size());
  std::iota(impl_->order.begin(), impl_->order.end(), 0);
  impl_->nodes.reserve(impl_->corners.size());
  impl_->build(0, static_cast<int>(impl_->corners.size()));
}

TriangleTree::~TriangleTree() = default;
TriangleTree::TriangleTree(TriangleTree&&) noexcept = default;

TriangleTree::Closest TriangleTree::closest(const Vector3d& p) const {
  double best = std::numeric_limits<double>::infinity();
  Closest result;
  impl_->visit([&](const Node& n) { return distance_squared(n, p); }, [&] { return best; },
               [&](int triangle, const Corners& c) {
                 const Vector3d q = closest_on_triangle(c, p);
                 const double d = (q - p).squaredNorm();
                 if (d < best) {
                   best = d;
                   result.point = q;
                   result.triangle = triangle;
                 }
               });
  result.distance = std::sqrt(best);
  return result;
}

TriangleTree::ClosestToSegment TriangleTree::closest_to_segment(const Vector3d& a, const Vector3d& b) const {
  const Vector3d way = b - a;
  const double length = way.squaredNorm();
  // Of a box: from the ball around it, or from the box around the segment. Never more than the true distance.
  const auto bound = [&](const Node& n) {
    const Vector3d middle = (n.lower + n.upper) / 2;
    const double t = length > 0 ? std::clamp((middle - a).dot(way) / length, 0.0, 1.0) : 0;
    const double by_ball = std::max(0.0, (a + t * way - middle).norm() - (n.upper - n.lower).norm() / 2);
    const double by_box = (n.lower - a.cwiseMax(b)).cwiseMax(a.cwiseMin(b) - n.upper).cwiseMax(0).norm();
    return std::max(by_ball, by_box);
  };
  ClosestToSegment best;
  best.distance = std::numeric_limits<double>::infinity();
  const auto offer = [&](double t, const Vector3d& point, int triangle) {
    const double d = (a + t * way - point).norm();
    if (d < best.distance) best = {d, t, point, triangle};
  };
  impl_->visit(bound, [&] { return best.distance; }, [&](int triangle, const Corners& c) {
    // Through the triangle, or from an end of the segment, or from an edge of the triangle.
    if (const auto t = ray_triangle(c, a, way); t && *t <= 1) offer(*t, a + *t * way, triangle);
    offer(0, closest_on_triangle(c, a), triangle);
    offer(1, closest_on_triangle(c, b), triangle);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d edge = c[(k + 1) % 3] - c[k];
      const auto [s, t] = closest_of_segments(a, way, c[k], edge);
      offer(s, c[k] + t * edge, triangle);
    }
  });
  return best;
}

std::optional<TriangleTree::Hit> TriangleTree::ray(const Vector3d& origin, const Vector3d& direction, double t_max) const {
  const Vector3d inverse = direction.cwiseInverse();
  std::optional<Hit> best;
  double reach = t_max;
  std::array<int, 128> stack;
  int top = 0;
  stack[static_cast<std::size_t>(top++)] = 0;
  while (top > 0) {
    const int at = stack[static_cast<std::size_t>(--top)];
    const Node& n = impl_->nodes[static_cast<std::size_t>(at)];
    if (!ray_box(n, origin, inverse, reach)) continue;
    if (n.count == 0) {
      stack[static_cast<std::size_t>(top++)] = n.first;
      stack[static_cast<std::size_t>(top++)] = at + 1;
      continue;
    }
    for (int i = n.first; i < n.first + n.count; ++i) {
      const int triangle = impl_->order[static_cast<std::size_t>(i)];
      const auto t = ray_triangle(impl_->corners[static_cast<std::size_t>(triangle)], origin, direction);
      if (t && *t <= reach) {
        reach = *t;
        best = Hit{*t, triangle};
      }
    }
  }
  return best;
}

}  // namespace periplus::mesh
