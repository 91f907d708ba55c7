#include "common/mesh/part_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::mesh {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kBandEdge = 0.06;  // of a band's height, kept free of what is painted beside it

// Points of a circle about `center`, in the plane of two unit vectors.
std::vector<Vector3d> circle(const Vector3d& center, const Vector3d& across, const Vector3d& along, double radius, int sides) {
  std::vector<Vector3d> ring;
  for (int k = 0; k < sides; ++k) ring.push_back(center + radius * (std::cos(kTurn * k / sides) * across + std::sin(kTurn * k / sides) * along));
  return ring;
}

}  // namespace

int PartBuilder::vertex(const Vector3d& p) {
  mesh_.vertices.push_back(p);
  return static_cast<int>(mesh_.vertices.size()) - 1;
}

void PartBuilder::triangle(int a, int b, int c, const Vector2d& ua, const Vector2d& ub, const Vector2d& uc) {
  mesh_.triangles.emplace_back(a, b, c);
  mesh_.corner_uv.insert(mesh_.corner_uv.end(), {ua, ub, uc});
}

void PartBuilder::paint(const Grid& grid, Material material) {
  const double band = 1.0 / kMaterials, room = band * (1 - 2 * kBandEdge);
  const double lower = band * (static_cast<int>(material) + kBandEdge);
  const auto at = [&](std::size_t i, std::size_t j) { return mesh_.vertices[static_cast<std::size_t>(grid[i][j])]; };
  // Each part begins at another place of the picture.
  const double shift = 0.618034 * static_cast<double>(mesh_.triangles.size() % 9973);
  double used = 0;
  for (std::size_t j = 0; j + 1 < grid[0].size(); ++j) {
    double width = 0;
    for (std::size_t i = 0; i < grid.size(); ++i) width = std::max(width, (at(i, j + 1) - at(i, j)).norm() / picture_);
    width = std::min(width, room);
    if (used + width > room) used = 0;  // a seam: the next strip of the band begins below again
    double u = shift;
    for (std::size_t i = 0; i + 1 < grid.size(); ++i) {
      const double next = u + ((at(i + 1, j) - at(i, j)) + (at(i + 1, j + 1) - at(i, j + 1))).norm() / 2 / picture_;
      const Vector2d a(u, lower + used), b(next, lower + used), c(next, lower + used + width), d(u, lower + used + width);
      const int p = grid[i][j], q = grid[i + 1][j], r = grid[i + 1][j + 1], s = grid[i][j + 1];
      triangle(p, q, r, a, b, c);
      triangle(p, r, s, a, c, d);
      u = next;
    }
    used += width;
  }
}

void PartBuilder::cap(std::vector<int> ring, Material material) {
  // The ring is counter-clockwise seen from outside.
  Vector3d middle = Vector3d::Zero();
  for (const int v : ring) middle += mesh_.vertices[static_cast<std::size_t>(v)];
  middle /= static_cast<double>(ring.size());
  double radius = 0;
  for (const int v : ring) radius = std::max(radius, (mesh_.vertices[static_cast<std::size_t>(v)] - middle).norm());
  const int steps = std::max(1, static_cast<int>(std::ceil(radius / (0.05 * picture_))));
  std::vector<Vector3d> outer;
  for (const int v : ring) outer.push_back(mesh_.vertices[static_cast<std::size_t>(v)]);
  for (int k = steps - 1; k >= 1; --k) {
    std::vector<int> inner;
    for (const Vector3d& p : outer) inner.push_back(vertex(middle + (p - middle) * k / steps));
    Grid grid(2);
    for (std::size_t j = 0; j <= ring.size(); ++j) {
      grid[0].push_back(inner[j % ring.size()]);
      grid[1].push_back(ring[j % ring.size()]);
    }
    paint(grid, material);
    ring = inner;
  }
  const int center = vertex(middle);
  const double v = (static_cast<int>(material) + 0.5) / kMaterials;
  const auto from_middle = [&](int k) -> Vector3d { return mesh_.vertices[static_cast<std::size_t>(k)] - middle; };
  const Vector3d across = from_middle(ring[0]).normalized();
  const Vector3d along = from_middle(ring[0]).cross(from_middle(ring[ring.size() / 3])).cross(across).normalized();
  const auto uv = [&](int k) {
    const double limit = 0.4 / kMaterials;
    return Vector2d(from_middle(k).dot(across) / picture_, v + std::clamp(from_middle(k).dot(along) / picture_, -limit, limit));
  };
  for (std::size_t j = 0; j < ring.size(); ++j) {
    const int a = ring[j], b = ring[(j + 1) % ring.size()];
    triangle(a, b, center, uv(a), uv(b), uv(center));
  }
}

void PartBuilder::loft(const std::vector<std::vector<Vector3d>>& rings, Material material, bool joined) {
  require(rings.size() >= (joined ? 3u : 2u) && rings[0].size() >= 3, ErrorCode::bad_input, "mesh: a loft needs rings of at least three points");
  Grid grid;
  for (const auto& ring : rings) {
    require(ring.size() == rings[0].size(), ErrorCode::bad_input, "mesh: the rings of a loft need equally many points");
    std::vector<int> row;
    for (const Vector3d& p : ring) row.push_back(vertex(p));
    grid.push_back(row);
  }
  const std::vector<int> first = grid.front(), last = grid.back();
  for (auto& row : grid) row.push_back(row.front());
  if (joined) grid.push_back(grid.front());
  // Counter-clockwise seen from the next ring: row x column points inwards, so the columns are taken the other way.
  for (auto& row : grid) std::reverse(row.begin(), row.end());
  paint(grid, material);
  if (joined) return;
  cap({first.rbegin(), first.rend()}, material);
  cap(last, material);
}

void PartBuilder::tube(const std::vector<Vector3d>& line, const std::vector<double>& radii, int sides, Material material, bool joined) {
  require(line.size() == radii.size() && line.size() >= 2, ErrorCode::bad_input, "mesh: a tube needs a radius at each point of its line");
  const std::size_t n = line.size();
  std::vector<std::vector<Vector3d>> rings;
  Vector3d across = Vector3d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d ahead = joined ? Vector3d(line[(i + 1) % n] - line[(i + n - 1) % n]) : Vector3d(line[std::min(i + 1, n - 1)] - line[i > 0 ? i - 1 : 0]);
    const Vector3d t = ahead.normalized();
    if (i == 0) across = std::abs(t.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
    across = (across - across.dot(t) * t).normalized();  // carried along: the rings do not twist
    rings.push_back(circle(line[i], across, t.cross(across), radii[i], sides));
  }
  loft(rings, material, joined);
}

void PartBuilder::tube(const Vector3d& from, const Vector3d& to, double radius_from, double radius_to, int sides, Material material) {
  const int pieces = std::max(1, static_cast<int>(std::ceil((to - from).norm() / 0.15)));
  std::vector<Vector3d> line;
  std::vector<double> radii;
  for (int i = 0; i <= pieces; ++i) {
    const double t = static_cast<double>(i) / pieces;
    line.push_back(from + t * (to - from));
    radii.push_back(radius_from + t * (radius_to - radius_from));
  }
  tube(line, radii, sides, material);
}

void PartBuilder::box(const Pose& X_MB, const Vector3d& size, double piece, Material material) {
  const Vector3d h = size / 2;
  const auto count = [&](double length) { return std::max(1, static_cast<int>(std::ceil(length / piece))); };
  const int nx = count(size.x()), ny = count(size.y()), nz = count(size.z());
  std::vector<std::vector<Vector3d>> rings;
  for (int i = 0; i <= nx; ++i) {
    const double x = -h.x() + size.x() * i / nx;
    std::vector<Vector3d> ring;  // y to z: counter-clockwise seen from +x
    for (int k = 0; k < ny; ++k) ring.push_back(X_MB * Vector3d(x, -h.y() + size.y() * k / ny, -h.z()));
    for (int k = 0; k < nz; ++k) ring.push_back(X_MB * Vector3d(x, h.y(), -h.z() + size.z() * k / nz));
    for (int k = 0; k < ny; ++k) ring.push_back(X_MB * Vector3d(x, h.y() - size.y() * k / ny, h.z()));
    for (int k = 0; k < nz; ++k) ring.push_back(X_MB * Vector3d(x, -h.y(), h.z() - size.z() * k / nz));
    rings.push_back(ring);
  }
  loft(rings, material);
}

void PartBuilder::sheet(const std::vector<std::vector<Vector3d>>& front, double thickness, Material material) {
  require(front.size() >= 2 && front[0].size() >= 2, ErrorCode::bad_input, "mesh: a sheet needs two rows and two columns");
  const std::size_t n = front.size(), m = front[0].size();
  Grid ahead(n), behind(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < m; ++j) {
      const Vector3d row = front[std::min(i + 1, n - 1)][j] - front[i > 0 ? i - 1 : 0][j];
      const Vector3d column = front[i][std::min(j + 1, m - 1)] - front[i][j > 0 ? j - 1 : 0];
      ahead[i].push_back(vertex(front[i][j]));
      behind[i].push_back(vertex(front[i][j] - thickness * row.cross(column).normalized()));
    }
  paint(ahead, material);
  Grid back = behind;
  for (auto& row : back) std::reverse(row.begin(), row.end());
  paint(back, material);
  // The rim, once around, counter-clockwise seen from the front.
  Grid rim(2);
  const auto add = [&](std::size_t i, std::size_t j) {
    rim[0].push_back(behind[i][j]);
    rim[1].push_back(ahead[i][j]);
  };
  for (std::size_t i = 0; i < n - 1; ++i) add(i, 0);
  for (std::size_t j = 0; j < m - 1; ++j) add(n - 1, j);
  for (std::size_t i = n - 1; i > 0; --i) add(i, m - 1);
  for (std::size_t j = m - 1; j > 0; --j) add(0, j);
  add(0, 0);
  for (auto& row : rim) std::reverse(row.begin(), row.end());
  paint(rim, material);
}

void PartBuilder::lump(const Vector3d& center, const Vector3d& half, double bumps, std::uint64_t seed, Material material) {
  constexpr int kWaves = 6, kSides = 24, kRings = 13;
  Random random(seed);
  Vector3d wave[kWaves];
  double phase[kWaves];
  for (int k = 0; k < kWaves; ++k) {
    wave[k] = Vector3d(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5));
    phase[k] = random.uniform(0, kTurn);
  }
  std::vector<std::vector<Vector3d>> rings;
  for (int i = 0; i < kRings; ++i) {
    const double up = std::numbers::pi * ((i + 0.5) / kRings - 0.5);
    std::vector<Vector3d> ring;
    for (int j = 0; j < kSides; ++j) {
      const double a = kTurn * j / kSides;
      const Vector3d d(std::cos(up) * std::cos(a), std::cos(up) * std::sin(a), std::sin(up));
      double swell = 0;
      for (int k = 0; k < kWaves; ++k) swell += std::sin(wave[k].dot(d) + phase[k]) / kWaves;
      ring.push_back(center + (1 + bumps * swell) * half.cwiseProduct(d));
    }
    rings.push_back(ring);
  }
  loft(rings, material);
}

}  // namespace periplus::mesh
