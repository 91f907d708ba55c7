// Boxes, cylinders and spheres as textured meshes.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/mesh/triangle_mesh.h"

namespace periplus::mesh {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPiece = 0.25;  // [m]
constexpr int kRound = 64;       // sides of a round solid: its outline is true to 0.12 % of the radius

int pieces(double length) { return std::clamp(static_cast<int>(std::ceil(length / kPiece)), 1, 40); }

// Adds the patch (i, j) in nu x nv pieces; point, normal and texture place are functions of s, t in 0..1. The patch faces
// the side from which s, t turn counter-clockwise.
template <class Point, class Normal, class Uv>
void add_patch(TriangleMesh& m, int nu, int nv, Point point, Normal normal, Uv uv) {
  const int first = static_cast<int>(m.vertices.size());
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i) m.vertices.push_back(point(double(i) / nu, double(j) / nv));
  const auto corner = [&](int i, int j) {
    m.corner_uv.push_back(uv(double(i) / nu, double(j) / nv));
    m.corner_normals.push_back(normal(double(i) / nu, double(j) / nv));
    return first + j * (nu + 1) + i;
  };
  const auto triangle = [&](int i0, int j0, int i1, int j1, int i2, int j2) {
    const int a = corner(i0, j0), b = corner(i1, j1), c = corner(i2, j2);
    m.triangles.emplace_back(a, b, c);
  };
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      triangle(i, j, i + 1, j, i + 1, j + 1);
      triangle(i, j, i + 1, j + 1, i, j + 1);
    }
}

// Drops triangles without area (at the poles of a sphere, in the middle of a disc).
void drop_slivers(TriangleMesh& m) {
  TriangleMesh kept;
  kept.vertices = std::move(m.vertices);
  for (std::size_t i = 0; i < m.triangles.size(); ++i) {
    const Eigen::Vector3i& t = m.triangles[i];
    const Vector3d& a = kept.vertices[static_cast<std::size_t>(t[0])];
    const Vector3d n = (kept.vertices[static_cast<std::size_t>(t[1])] - a).cross(kept.vertices[static_cast<std::size_t>(t[2])] - a);
    if (n.norm() < 1e-12) continue;
    kept.triangles.push_back(t);
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
      kept.corner_uv.push_back(m.corner_uv[k]);
      kept.corner_normals.push_back(m.corner_normals[k]);
    }
  }
  m = std::move(kept);
}

void require_size(double smallest) {
  require(std::isfinite(smallest) && smallest > 0, ErrorCode::bad_input, "mesh: a solid needs positive sizes");
}

}  // namespace

TriangleMesh make_box(const Vector3d& size, double pictures_per_metre) {
  require_size(size.minCoeff());
  TriangleMesh m;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      // s runs along `across`, t along `along`; their order turns the patch outwards.
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      const int across = side > 0 ? a : b, along = side > 0 ? b : a;
      Vector3d normal = Vector3d::Zero();
      normal[axis] = side;
      const Vector2d shift(0.37 * axis, 0.19 * side);  // so that no two faces look alike
      add_patch(
          m, pieces(size[across]), pieces(size[along]),
          [&](double s, double t) {
            Vector3d p;
            p[axis] = side * size[axis] / 2;
            p[across] = (s - 0.5) * size[across];
            p[along] = (t - 0.5) * size[along];
            return p;
          },
          [&](double, double) { return normal; },
          [&](double s, double t) { return Vector2d(shift + pictures_per_metre * Vector2d(s * size[across], t * size[along])); });
    }
  return m;
}

TriangleMesh make_cylinder(double diameter, double height, double pictures_per_metre) {
  require_size(std::min(diameter, height));
  const double r = diameter / 2, turn = 2 * std::numbers::pi;
  const auto direction = [&](double s) { return Vector3d(std::cos(turn * s), std::sin(turn * s), 0); };
  TriangleMesh m;
  add_patch(
      m, kRound, pieces(height), [&](double s, double t) { return Vector3d(r * direction(s) + Vector3d(0, 0, (t - 0.5) * height)); },
      [&](double s, double) { return direction(s); },
      [&](double s, double t) { return Vector2d(pictures_per_metre * Vector2d(turn * r * s, height * t)); });
  for (const double side : {-1.0, 1.0})
    add_patch(
        m, kRound, 2,
        [&](double s, double t) { return Vector3d((1 - t) * r * direction(side * s) + Vector3d(0, 0, side * height / 2)); },
        [&](double, double) { return Vector3d(0, 0, side); },
        [&](double s, double t) { return Vector2d(pictures_per_metre * ((1 - t) * r * direction(side * s)).head<2>()); });
  drop_slivers(m);
  return m;
}

TriangleMesh make_sphere(double diameter, double pictures_per_metre) {
  require_size(diameter);
  const double r = diameter / 2, turn = 2 * std::numbers::pi;
  const auto direction = [&](double s, double t) {
    const double up = std::numbers::pi * (t - 0.5);
    return Vector3d(std::cos(up) * std::cos(turn * s), std::cos(up) * std::sin(turn * s), std::sin(up));
  };
  TriangleMesh m;
  add_patch(
      m, kRound, kRound / 2, [&](double s, double t) { return Vector3d(r * direction(s, t)); }, direction,
      [&](double s, double t) { return Vector2d(pictures_per_metre * r * Vector2d(turn * s, std::numbers::pi * t)); });
  drop_slivers(m);
  return m;
}

}  // namespace periplus::mesh
