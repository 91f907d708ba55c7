#include "common/scene/mesh_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "common/core/error.h"
#include "common/mesh/made_models.h"

namespace periplus::scene {
namespace {

using Eigen::Vector3d;

constexpr double kOnSurface = 1e-9;  // [m]
constexpr int kDepths = 16;          // pieces of a segment that is looked at for its depth

mesh::TriangleMesh centred(mesh::TriangleMesh m) {
  m.check();
  require(!m.empty(), ErrorCode::bad_input, "a mesh among the solids needs triangles");
  require(m.triangles.size() <= MeshSolid::kMostTriangles, ErrorCode::bad_size,
          "a mesh among the solids may have at most " + std::to_string(MeshSolid::kMostTriangles) + " triangles, this one has " +
              std::to_string(m.triangles.size()) + "; simplify it");
  const mesh::Bounds b = mesh::bounds(m);
  const Vector3d middle = (b.lower + b.upper) / 2;
  for (Vector3d& p : m.vertices) p -= middle;
  return m;
}

// Every edge is run through once in each direction. Vertices of one place are one, whatever their numbers.
bool is_closed(const mesh::TriangleMesh& m) {
  const double unit = 1e-7 * mesh::bounds(m).size().maxCoeff();
  std::map<std::array<long, 3>, int> places;
  std::vector<int> place;
  for (const Vector3d& p : m.vertices) {
    const std::array<long, 3> at{std::lround(p.x() / unit), std::lround(p.y() / unit), std::lround(p.z() / unit)};
    place.push_back(places.emplace(at, static_cast<int>(places.size())).first->second);
  }
  std::set<std::pair<int, int>> edges;
  for (const Eigen::Vector3i& t : m.triangles)
    for (int k = 0; k < 3; ++k)
      if (!edges.insert({place[static_cast<std::size_t>(t[k])], place[static_cast<std::size_t>(t[(k + 1) % 3])]}).second) return false;
  return std::all_of(edges.begin(), edges.end(), [&](const auto& e) { return edges.contains({e.second, e.first}); });
}

}  // namespace

MeshSolid::MeshSolid(mesh::TriangleMesh mesh) : mesh_(centred(std::move(mesh))), size_(mesh::bounds(mesh_).size()), closed_(is_closed(mesh_)), tree_(mesh_) {
  if (closed_ && mesh::signed_volume(mesh_) < 0) mesh::flip(mesh_);
}

std::shared_ptr<const MeshSolid> MeshSolid::load(const std::string& name, double longest_side, std::string_view up_axis) {
  std::string path;
  mesh::TriangleMesh m = mesh::load_named(name, {}, path);
  mesh::scale_upright(m, longest_side, up_axis);
  return std::make_shared<const MeshSolid>(std::move(m));
}

bool MeshSolid::inside(const Vector3d& p) const {
  if (!closed_ || (p.cwiseAbs().array() > size_.array() / 2).any()) return false;
  // An odd number of crossings, by two of three directions: a ray along an edge may count wrong.
  static const std::array<Vector3d, 3> directions{Vector3d(0.36, 0.48, 0.8), Vector3d(-0.8, 0.36, 0.48), Vector3d(0.48, -0.8, -0.36)};
  const double step = 1e-9 * size_.maxCoeff();
  int odd = 0;
  for (const Vector3d& d : directions) {
    Vector3d from = p;
    bool in = false;
    while (const auto hit = tree_.ray(from, d)) {
      in = !in;
      from += (hit->t + step) * d;
    }
    odd += in;
  }
  return odd >= 2;
}

double MeshSolid::distance(const Vector3d& p, Vector3d& gradient) const {
  const mesh::TriangleTree::Closest c = tree_.closest(p);
  if (c.distance < kOnSurface) {
    const Eigen::Vector3i& t = mesh_.triangles[static_cast<std::size_t>(c.triangle)];
    const auto corner = [&](int k) -> const Vector3d& { return mesh_.vertices[static_cast<std::size_t>(t[k])]; };
    gradient = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    return 0;
  }
  const double sign = inside(p) ? -1 : 1;
  gradient = sign * (p - c.point) / c.distance;
  return sign * c.distance;
}

double MeshSolid::segment_distance(const Vector3d& a, const Vector3d& b, double& share, Vector3d& gradient) const {
  const mesh::TriangleTree::ClosestToSegment c = tree_.closest_to_segment(a, b);
  if (c.distance >= kOnSurface && !inside(a)) {
    share = c.t;
    gradient = (a + c.t * (b - a) - c.point) / c.distance;
    return c.distance;
  }
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kDepths; ++i) {
    const double t = static_cast<double>(i) / kDepths;
    Vector3d grows;
    const double d = distance(a + t * (b - a), grows);
    if (d >= least) continue;
    least = d;
    share = t;
    gradient = grows;
  }
  if (least > 0) {  // only the point where it meets the mesh touches it
    share = c.t;
    least = distance(a + c.t * (b - a), gradient);
  }
  return least;
}

std::optional<double> MeshSolid::first_hit(const Vector3d& p, const Vector3d& d) const {
  if (inside(p)) return 0;
  const auto hit = tree_.ray(p, d, 1);
  return hit ? std::optional<double>(hit->t) : std::nullopt;
}

}  // namespace periplus::scene
