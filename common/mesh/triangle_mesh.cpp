#include "common/mesh/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::mesh {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;

Vector3d area_vector(const TriangleMesh& m, const Vector3i& t) {
  const Vector3d& a = m.vertices[static_cast<std::size_t>(t[0])];
  return (m.vertices[static_cast<std::size_t>(t[1])] - a).cross(m.vertices[static_cast<std::size_t>(t[2])] - a) / 2;
}

bool all_finite(const auto& list) {
  return std::all_of(list.begin(), list.end(), [](const auto& v) { return v.allFinite(); });
}

}  // namespace

void TriangleMesh::check() const {
  require(all_finite(vertices) && all_finite(corner_uv) && all_finite(corner_normals) && all_finite(colours), ErrorCode::not_finite,
          "mesh: a coordinate is not a finite number");
  const auto count = static_cast<int>(vertices.size());
  for (const Vector3i& t : triangles)
    require(t.minCoeff() >= 0 && t.maxCoeff() < count, ErrorCode::bad_input, "mesh: a triangle names a vertex that does not exist");
  const std::size_t corners = 3 * triangles.size();
  require((corner_uv.empty() || corner_uv.size() == corners) && (corner_normals.empty() || corner_normals.size() == corners) &&
              (colours.empty() || colours.size() == vertices.size()),
          ErrorCode::bad_size, "mesh: texture coordinates, normals or colours do not fit the number of triangles");
}

Bounds bounds(const TriangleMesh& mesh) {
  require(!mesh.vertices.empty(), ErrorCode::bad_input, "mesh: there are no vertices");
  Bounds b{mesh.vertices.front(), mesh.vertices.front()};
  for (const Vector3d& p : mesh.vertices) {
    b.lower = b.lower.cwiseMin(p);
    b.upper = b.upper.cwiseMax(p);
  }
  return b;
}

double surface_area(const TriangleMesh& mesh) {
  double area = 0;
  for (const Vector3i& t : mesh.triangles) area += area_vector(mesh, t).norm();
  return area;
}

double signed_volume(const TriangleMesh& mesh) {
  double volume = 0;
  for (const Vector3i& t : mesh.triangles)
    volume += area_vector(mesh, t).dot(mesh.vertices[static_cast<std::size_t>(t[0])]) / 3;
  return volume;
}

void flip(TriangleMesh& mesh) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
    if (!mesh.corner_uv.empty()) std::swap(mesh.corner_uv[3 * i + 1], mesh.corner_uv[3 * i + 2]);
    if (!mesh.corner_normals.empty()) std::swap(mesh.corner_normals[3 * i + 1], mesh.corner_normals[3 * i + 2]);
  }
  for (Vector3d& n : mesh.corner_normals) n = -n;
}

void transform(TriangleMesh& mesh, const Pose& X_AM) {
  for (Vector3d& p : mesh.vertices) p = X_AM * p;
  for (Vector3d& n : mesh.corner_normals) n = X_AM.linear() * n;
}

Placement scale_upright(TriangleMesh& mesh, double longest_side, std::string_view up_axis) {
  require(std::isfinite(longest_side) && longest_side > 0, ErrorCode::bad_input, "mesh: the longest side must be a positive length");
  const bool negative = up_axis.starts_with('-');
  const std::string_view letter = up_axis.substr(negative ? 1 : 0);
  require(letter == "x" || letter == "y" || letter == "z", ErrorCode::bad_input, "mesh: up axis must be x, y, z, -x, -y or -z");
  const int up = letter[0] - 'x';
  const double sign = negative ? -1 : 1;
  // Rows: where new x, y, z come from. The next axes in cyclic order keep it a rotation.
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
  R(2, up) = sign;
  R(0, (up + 1) % 3) = sign;
  R(1, (up + 2) % 3) = 1;
  if (up == 1) {  // y up: x stays x, as in most files that are drawn with y up
    R.setZero();
    R(0, 0) = sign;
    R(1, 2) = -1;
    R(2, 1) = sign;
  }
  transform(mesh, make_pose(Vector3d::Zero(), R));
  const Bounds b = bounds(mesh);
  const double longest = b.size().maxCoeff();
  require(longest > 0, ErrorCode::bad_input, "mesh: all its vertices are one point");
  const double scale = longest_side / longest;
  const Vector3d bottom((b.lower.x() + b.upper.x()) / 2, (b.lower.y() + b.upper.y()) / 2, b.lower.z());
  for (Vector3d& p : mesh.vertices) p = scale * (p - bottom);
  return {make_pose(-scale * bottom, R), scale};
}

void compute_normals(TriangleMesh& mesh) {
  std::vector<Vector3d> sums(mesh.vertices.size(), Vector3d::Zero());
  for (const Vector3i& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) sums[static_cast<std::size_t>(t[k])] += area_vector(mesh, t);
  mesh.corner_normals.clear();
  mesh.corner_normals.reserve(3 * mesh.triangles.size());
  for (const Vector3i& t : mesh.triangles) {
    Vector3d face = area_vector(mesh, t);
    face = face.norm() > 0 ? Vector3d(face.normalized()) : Vector3d::UnitZ();
    for (int k = 0; k < 3; ++k) {
      const Vector3d& sum = sums[static_cast<std::size_t>(t[k])];
      const bool crease = !(sum.dot(face) > 0.5 * sum.norm());
      mesh.corner_normals.push_back(crease ? face : Vector3d(sum.normalized()));
    }
  }
}

void unwrap_six_tiles(TriangleMesh& mesh, double tile_side) {
  require(std::isfinite(tile_side) && tile_side > 0, ErrorCode::bad_input, "mesh: the side of a texture tile must be positive");
  if (mesh.corner_normals.empty()) compute_normals(mesh);
  const Bounds b = bounds(mesh);
  const Vector3d middle = (b.lower + b.upper) / 2;
  mesh.corner_uv.resize(3 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    // By the smoothed normals, so that the seams between tiles run straight over a rough surface.
    const Vector3d n = mesh.corner_normals[3 * i] + mesh.corner_normals[3 * i + 1] + mesh.corner_normals[3 * i + 2];
    int axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    const int tile = 2 * axis + (n[axis] > 0 ? 1 : 0);
    for (int k = 0; k < 3; ++k) {
      const Vector3d p = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][k])] - middle;
      const double u = p[(axis + 1) % 3] / tile_side + 0.5, v = p[(axis + 2) % 3] / tile_side + 0.5;
      mesh.corner_uv[3 * i + static_cast<std::size_t>(k)] = {(tile % 3 + u) / 3, (tile / 3 + v) / 2};  // NOLINT: whole tiles
    }
  }
}

std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  std::vector<double> sums;
  sums.reserve(mesh.triangles.size());
  double total = 0;
  for (const Vector3i& t : mesh.triangles) sums.push_back(total += area_vector(mesh, t).norm());
  require(total > 0, ErrorCode::bad_input, "mesh: it has no surface to sample");
  Random random(seed);
  std::vector<SurfaceSample> samples;
  samples.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto found = std::upper_bound(sums.begin(), sums.end(), random.uniform() * total);
    const auto index = static_cast<std::size_t>(std::min<std::ptrdiff_t>(found - sums.begin(), static_cast<std::ptrdiff_t>(sums.size()) - 1));
    const Vector3i& t = mesh.triangles[index];
    const double root = std::sqrt(random.uniform()), v = random.uniform();
    const Vector3d p = (1 - root) * mesh.vertices[static_cast<std::size_t>(t[0])] +
                       root * (1 - v) * mesh.vertices[static_cast<std::size_t>(t[1])] + root * v * mesh.vertices[static_cast<std::size_t>(t[2])];
    samples.push_back({p, area_vector(mesh, t).normalized(), static_cast<int>(index)});
  }
  return samples;
}

}  // namespace periplus::mesh
