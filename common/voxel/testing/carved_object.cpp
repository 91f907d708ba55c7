#include "common/voxel/testing/carved_object.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/core/random.h"

namespace periplus::voxel::testing {
namespace {

using Eigen::Vector3d;

const Vector3d kMiddle(0, 0, 1.15);

// Signed distance to the object of radius about 1, a bound inside.
double distance_to_object(const Vector3d& p) {
  const auto ball = [&](const Vector3d& c, double r) { return (p - c).norm() - r; };
  double d = std::max(ball({0, 0, 0}, 0.75), -ball({0.45, 0.15, 0.25}, 0.5));
  const Vector3d ring = p - Vector3d(-0.62, -0.1, 0.1);
  d = std::min(d, std::hypot(std::hypot(ring.x(), ring.z()) - 0.3, ring.y()) - 0.09);
  const double radial = std::hypot(p.x(), p.y()) - 0.5, axial = std::abs(p.z() + 0.75) - 0.15;
  d = std::min(d, std::hypot(std::max(radial, 0.0), std::max(axial, 0.0)) + std::min(std::max(radial, axial), 0.0));
  const Vector3d from(0, -0.3, 0.5), along(-0.2, -0.3, 0.35);
  const double t = std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  d = std::min(d, (p - from - t * along).norm() - 0.1);
  const Vector3d block = (p - Vector3d(0.1, 0.7, 0.35)).cwiseAbs() - Vector3d(0.2, 0.15, 0.3);
  return std::min(d, block.maxCoeff());
}

// Depth along the axis, infinite where nothing is.
std::vector<double> depth_of_object(const Pose& X_WC, const Pinhole& camera, double radius) {
  std::vector<double> depth(static_cast<std::size_t>(camera.width) * camera.height, std::numeric_limits<double>::infinity());
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d d = X_WC.linear() * camera.back_project(x, y, 1), u = d.normalized(), o = X_WC.translation() - kMiddle;
      const double b = o.dot(u), root = b * b - o.squaredNorm() + radius * radius * 1.21;
      if (root < 0) continue;
      double t = std::max(0.0, -b - std::sqrt(root));
      for (int k = 0; k < 200 && t < -b + std::sqrt(root); ++k) {
        const double step = distance_to_object((o + t * u) / radius);
        if (step < 2e-4) {
          depth[static_cast<std::size_t>(y) * camera.width + x] = t / d.norm();
          break;
        }
        t += step * radius;
      }
    }
  }
  return depth;
}

// Known where depth says so, then empty where all of a voxel's pixels see further.
void carve(const Pose& X_WC, const Pinhole& camera, const std::vector<double>& depth, OccupancyGrid& grid) {
  const GridGeometry& g = grid.geometry();
  const auto at = [&](int x, int y) { return depth[static_cast<std::size_t>(y) * camera.width + x]; };
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (!std::isfinite(at(x, y))) continue;
      const Eigen::Vector3i v = g.voxel_of(X_WC * camera.back_project(x, y, at(x, y) + 1e-4));
      if (g.contains(v) && grid.state(v) == VoxelState::unknown) grid.set_state(v, VoxelState::known);
    }
  }
  const Pose X_CG = X_WC.inverse() * g.X_WG;
  for (int i = 0; i < g.size.x(); ++i) {
    for (int j = 0; j < g.size.y(); ++j) {
      for (int k = 0; k < g.size.z(); ++k) {
        if (grid.state({i, j, k}) != VoxelState::unknown) continue;
        Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
        double middle = 0;
        for (int c = 0; c < 8; ++c) {
          const Vector3d p = X_CG * (g.voxel_size * Vector3d(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)));
          const Eigen::Vector2d pixel = camera.project(p);
          low = low.cwiseMin(pixel);
          high = high.cwiseMax(pixel);
          middle += p.z() / 8;
        }
        const int x0 = static_cast<int>(std::floor(low.x() + 0.5)), x1 = static_cast<int>(std::floor(high.x() + 0.5));
        const int y0 = static_cast<int>(std::floor(low.y() + 0.5)), y1 = static_cast<int>(std::floor(high.y() + 0.5));
        if (x0 < 0 || y0 < 0 || x1 >= camera.width || y1 >= camera.height) continue;
        bool free = true;
        for (int y = y0; y <= y1 && free; ++y) {
          for (int x = x0; x <= x1; ++x) free &= at(x, y) > middle + 0.5 * g.voxel_size;
        }
        if (free) grid.set_state({i, j, k}, VoxelState::empty);
      }
    }
  }
}

struct Box {
  Vector3d low, high;
  Occluder occluder() const { return Occluder::box(make_pose((low + high) / 2, Eigen::Matrix3d::Identity()), high - low); }
};

std::vector<Box> boxes_around(double side, double half) {
  std::vector<Box> boxes;
  boxes.push_back({{-2 * side, -2 * side, kMiddle.z() - half - 0.05 * side}, {2 * side, 2 * side, kMiddle.z() - half - 1e-6}});
  for (int i = 0; i < 4; ++i) {
    const Vector3d c(12 * std::cos(i * std::numbers::pi / 2), 12 * std::sin(i * std::numbers::pi / 2), 1);
    boxes.push_back({c - Vector3d(1, 1, 1), c + Vector3d(1, 1, 2)});
  }
  Random random(7);
  while (boxes.size() < 24) {
    const double angle = random.uniform(0, 2 * std::numbers::pi), away = random.uniform(0.95, 1.55) * side;
    const Vector3d c = kMiddle + Vector3d(away * std::cos(angle), away * std::sin(angle), random.uniform(-0.6, 0.6) * side);
    const Vector3d e(random.uniform(0.02, 0.12) * side, random.uniform(0.02, 0.12) * side, random.uniform(0.05, 0.3) * side);
    if (((c - kMiddle).cwiseAbs() - e).maxCoeff() > half) boxes.push_back({c - e, c + e});
  }
  return boxes;
}

}  // namespace

Pinhole carved_object_camera() { return Pinhole::from_vertical_fov(640, 480, 25 * std::numbers::pi / 180); }

CarvedObject carved_object(int cells, double longest_side, int looks) {
  GridGeometry g;
  g.voxel_size = 1.4 * longest_side / cells;
  g.size = {cells, cells, cells};
  g.X_WG = make_pose(kMiddle - Vector3d::Constant(0.7 * longest_side), Eigen::Matrix3d::Identity());
  CarvedObject object{OccupancyGrid(g), {}, {}};
  constexpr double kAzimuth[6] = {0.3, 2.2, 4.1, 1.2, 3.2, 5.3}, kElevation[6] = {0.15, 0.1, 0.35, 0.5, 0.0, 0.25};
  for (int i = 0; i < looks; ++i) {
    const double a = kAzimuth[i], e = kElevation[i];
    const Pose X_WC = look_at(kMiddle + 2.6 * longest_side * Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)), kMiddle);
    carve(X_WC, carved_object_camera(), depth_of_object(X_WC, carved_object_camera(), longest_side / 2), object.grid);
  }
  for (const Box& b : boxes_around(longest_side, 0.7 * longest_side)) object.occluders.push_back(b.occluder());
  std::vector<Eigen::Vector3i> known;
  const VisibilityScene scene(object.grid);
  for (std::uint32_t v : scene.surface()) {
    if (object.grid.state(scene.voxel(v)) == VoxelState::known) known.push_back(scene.voxel(v));
  }
  Random random(8);
  for (std::size_t i = 0; i < 500 && i < known.size(); ++i) {
    std::swap(known[i], known[i + random.below(known.size() - i)]);
    object.watched.push_back(known[i]);
  }
  return object;
}

std::vector<Pose> views_of(const CarvedObject& object, double longest_side, int count, std::uint64_t seed) {
  const GridGeometry& g = object.grid.geometry();
  const std::vector<Box> boxes = boxes_around(longest_side, 0.7 * longest_side);
  const double nearest = longest_side > 1 ? 2 : 1, farthest = 2 * nearest;
  Random random(seed);
  std::vector<Pose> views;
  while (views.size() < static_cast<std::size_t>(count)) {
    const double a = random.uniform(0, 2 * std::numbers::pi), e = random.uniform(-0.15, 0.7), away = random.uniform(nearest, farthest);
    const Vector3d p = kMiddle + away * Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e));
    bool free = true;
    for (const Box& b : boxes) free &= ((p - b.low).array() < -0.02).any() || ((b.high - p).array() < -0.02).any();
    const Eigen::Vector3i v = g.voxel_of(p);
    const int margin = static_cast<int>(0.15 * longest_side / g.voxel_size), step = std::max(1, margin / 4);
    for (int x = -margin; x <= margin && free; x += step) {
      for (int y = -margin; y <= margin; y += step) {
        for (int z = -margin; z <= margin; z += step) {
          const Eigen::Vector3i q = v + Eigen::Vector3i(x, y, z);
          free &= !g.contains(q) || object.grid.state(q) == VoxelState::empty;
        }
      }
    }
    if (!free) continue;
    const double q = 0.2 * longest_side;
    Pose X_WC = look_at(p, kMiddle + Vector3d(random.uniform(-q, q), random.uniform(-q, q), random.uniform(-q, q)));
    X_WC.linear() = X_WC.linear() * Eigen::AngleAxisd(random.uniform(-0.1, 0.1), Vector3d::UnitZ());
    views.push_back(X_WC);
  }
  return views;
}

}  // namespace periplus::voxel::testing
