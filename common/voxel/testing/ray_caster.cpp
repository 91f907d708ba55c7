#include "common/voxel/testing/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace periplus::voxel::testing {

std::optional<RayHit> cast_ray(const OccupancyGrid& grid, const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
  const Eigen::Vector3i n = grid.geometry().size;
  double t0 = 0, t1 = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    double lo = (0 - p[a]) / d[a], hi = (n[a] - p[a]) / d[a];
    if (lo > hi) std::swap(lo, hi);
    t0 = std::max(t0, lo);
    t1 = std::min(t1, hi);
  }
  if (t0 >= t1) return std::nullopt;
  const Eigen::Vector3d start = p + t0 * d;
  Eigen::Vector3i v;
  Eigen::Vector3d next;
  for (int a = 0; a < 3; ++a) {
    v[a] = std::clamp(static_cast<int>(std::floor(start[a])), 0, n[a] - 1);
    next[a] = ((d[a] > 0 ? v[a] + 1 : v[a]) - p[a]) / d[a];
  }
  const Eigen::Vector3i own = p.array().floor().cast<int>();
  while (grid.geometry().contains(v)) {
    if (v != own && grid.state(v) != VoxelState::empty) return RayHit{v, t0};
    int a;
    next.minCoeff(&a);
    v[a] += d[a] > 0 ? 1 : -1;
    next[a] += 1 / std::abs(d[a]);
  }
  return std::nullopt;
}

std::size_t RayCastView::voxels(std::uint32_t more_than_pixels) const {
  return static_cast<std::size_t>(std::count_if(unknown.begin(), unknown.end(), [&](const auto& v) { return v.second > more_than_pixels; }));
}

RayCastView ray_cast(const OccupancyGrid& grid, const Pose& X_WC, const Pinhole& camera, const Hidden& hidden) {
  RayCastView view;
  const GridGeometry& g = grid.geometry();
  const Pose X_GW = g.X_WG.inverse();
  const Eigen::Vector3d p = X_GW * X_WC.translation() / g.voxel_size;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d d_W = X_WC.linear() * camera.back_project(x, y, 1);
      const auto hit = cast_ray(grid, p, X_GW.linear() * d_W / g.voxel_size);
      if (!hit || (hidden && hidden(X_WC.translation(), d_W, hit->box_entry))) continue;
      const Eigen::Vector3i& v = hit->voxel;
      switch (grid.state(v)) {
        case VoxelState::unknown:
          ++view.unknown[(static_cast<std::uint32_t>(v.x()) * g.size.y() + v.y()) * g.size.z() + v.z()];
          break;
        case VoxelState::known:
          ++view.known;
          break;
        default:
          ++view.environment;
      }
    }
  }
  return view;
}

std::uint64_t difference(const RayCastView& expected, const VisibilityResult& result) {
  std::map<std::uint32_t, std::int64_t> delta;
  for (const auto& [v, n] : expected.unknown) delta[v] += n;
  for (const VoxelPixels& v : result.unknown) delta[v.voxel] -= v.pixels;
  std::int64_t sum = std::abs(static_cast<std::int64_t>(expected.known) - static_cast<std::int64_t>(result.known_pixels)) +
                     std::abs(static_cast<std::int64_t>(expected.environment) - static_cast<std::int64_t>(result.environment_pixels));
  for (const auto& [v, n] : delta) sum += std::abs(n);
  return static_cast<std::uint64_t>(sum);
}

}  // namespace periplus::voxel::testing
