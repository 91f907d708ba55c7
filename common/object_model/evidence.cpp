#include "common/object_model/evidence.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace periplus::object_model {

namespace {

template <class T>
void count(T& counter) {
  if (counter < std::numeric_limits<T>::max()) ++counter;
}

// Behind the measured depth, noise may have put the surface's voxel [voxels].
constexpr double kBehind = 0.3;
// The least depth around a pixel may lie this far before its own and still be the same, slanted surface [voxels].
constexpr double kSlant = 2.5;
constexpr double kStep = 0.5;  // [voxels]

// Least depth within a voxel's projection about a pixel: what has kept such a voxel from being emptied.
double least_around(const ImageF& minimum, int x, int y, int radius) {
  float least = minimum.at(x, y);
  for (int dy = -radius; dy <= radius; dy += radius)
    for (int dx = -radius; dx <= radius; dx += radius) {
      const int u = std::clamp(x + dx, 0, minimum.width - 1), v = std::clamp(y + dy, 0, minimum.height - 1);
      if (minimum.at(u, v) > 0) least = std::min(least, minimum.at(u, v));
    }
  return least;
}

// Calls visit(word, bit, voxel) for each bit set in `plane`.
template <class Visit>
void for_each_bit(const voxel::GridGeometry& g, const std::vector<std::uint64_t>& plane, Visit&& visit) {
  const Eigen::Vector3i nb = g.bricks();
  std::size_t word = 0;
  for (int bx = 0; bx < nb.x(); ++bx)
    for (int by = 0; by < nb.y(); ++by)
      for (int bz = 0; bz < nb.z(); ++bz)
        for (int x = 0; x < 8; ++x, ++word)
          for (std::uint64_t bits = plane[word]; bits; bits &= bits - 1) {
            const int b = std::countr_zero(bits);
            visit(word, 1ull << b, Eigen::Vector3i(bx * 8 + x, by * 8 + (b >> 3), bz * 8 + (b & 7)));
          }
}

}  // namespace

Evidence::Evidence(const voxel::GridGeometry& geometry) {
  const std::size_t n = static_cast<std::size_t>(geometry.size.x()) * geometry.size.y() * geometry.size.z();
  points.assign(n, 0);
  seen.assign(n, 0);
  solid.assign(n, 0);
  votes.assign(n, 0);
}

void add_points(const DepthMap& map, const PixelLimits& limits, const voxel::GridGeometry& geometry, const CarvingSettings& settings,
                Evidence& evidence) {
  const double h = geometry.voxel_size;
  const Pose X_GC = geometry.X_WG.inverse() * map.X_WC;
  const Eigen::Vector3d origin = X_GC.translation() / h;  // [voxels], as the rays
  const Eigen::Array3d upper = geometry.size.cast<double>().array();
  const double widest = std::max(map.depth.width, map.depth.height);  // [px]: a voxel before the lens fills the image
  const auto inside = [&](const Eigen::Vector3d& p) { return (p.array() >= 0).all() && (p.array() < upper).all(); };
  for (int y = 0; y < map.depth.height; ++y)
    for (int x = 0; x < map.depth.width; ++x) {
      const PixelKind kind = limits.kind.at(x, y);
      if (kind == PixelKind::none) continue;
      const double z = map.depth.at(x, y);
      const Eigen::Vector3d ray = X_GC.linear() * map.camera.back_project(x, y, 1) / h;
      const Eigen::Vector3d point = origin + ray * z;
      if ((point.array() < -4).any() || (point.array() > upper + 4).any()) continue;
      if (kind == PixelKind::surface && inside(point)) count(evidence.points[voxel_index(geometry, point.cast<int>())]);
      auto& counters = kind == PixelKind::surface ? evidence.seen : evidence.solid;
      const int radius = static_cast<int>(std::clamp(map.camera.fx * h / z, 1.0, widest));
      const double least = std::max(std::min(least_around(map.depth_minimum, x, y, radius), z), z - kSlant * h) - settings.margin_voxels * h;
      std::size_t last = std::numeric_limits<std::size_t>::max();
      for (double t = z + kBehind * h; t > least; t -= kStep * h) {
        const Eigen::Vector3d p = origin + ray * t;
        if (!inside(p)) continue;
        const std::size_t i = voxel_index(geometry, p.cast<int>());
        if (i != last) count(counters[i]);
        last = i;
      }
    }
}

void empty_voxels(const std::vector<std::uint64_t>& plane, bool cautious, const CarvingSettings& settings, voxel::OccupancyGrid& grid,
                  Evidence& evidence) {
  for_each_bit(grid.geometry(), plane, [&](std::size_t word, std::uint64_t bit, const Eigen::Vector3i& v) {
    std::uint8_t& votes = evidence.votes[voxel_index(grid.geometry(), v)];
    count(votes);
    if (cautious && votes < settings.cautious_votes) return;
    grid.occupied()[word] &= ~bit;
    grid.known()[word] &= ~bit;
    grid.environment()[word] &= ~bit;
  });
}

void label(const std::vector<std::uint64_t>& environment, const CarvingSettings& settings, const Evidence& evidence,
           voxel::OccupancyGrid& grid) {
  grid.known().assign(grid.known().size(), 0);
  grid.environment() = environment;
  for (std::size_t w = 0; w < environment.size(); ++w) grid.environment()[w] &= grid.occupied()[w];
  std::vector<std::uint64_t> open(environment.size());
  for (std::size_t w = 0; w < open.size(); ++w) open[w] = grid.occupied()[w] & ~environment[w];
  for_each_bit(grid.geometry(), open, [&](std::size_t word, std::uint64_t bit, const Eigen::Vector3i& v) {
    const std::size_t i = voxel_index(grid.geometry(), v);
    if (evidence.points[i] >= settings.known_points || evidence.seen[i] >= settings.seen_points)
      grid.known()[word] |= bit;
    else if (evidence.solid[i] >= settings.seen_points)
      grid.environment()[word] |= bit;
  });
}

}  // namespace periplus::object_model
