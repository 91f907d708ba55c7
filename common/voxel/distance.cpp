#include "common/voxel/distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace periplus::voxel {
namespace {

// f(i) becomes min_j f(j) + (i - j)^2 along one row of n.
void envelope(const std::vector<double>& f, int n, std::vector<double>& out, std::vector<int>& apex, std::vector<double>& from) {
  int k = -1;
  for (int q = 0; q < n; ++q) {
    if (std::isinf(f[q])) continue;
    double s = -1;
    while (k >= 0) {
      const int p = apex[k];
      s = ((f[q] + double(q) * q) - (f[p] + double(p) * p)) / (2.0 * (q - p));
      if (s > from[k]) break;
      --k;
    }
    ++k;
    apex[k] = q;
    from[k] = k == 0 ? -1 : s;
  }
  if (k < 0) {
    std::fill_n(out.begin(), n, std::numeric_limits<double>::infinity());
    return;
  }
  for (int i = 0, at = 0; i < n; ++i) {
    while (at < k && from[at + 1] < i) ++at;
    const double d = i - apex[at];
    out[i] = f[apex[at]] + d * d;
  }
}

}  // namespace

std::vector<float> distance_to_state(const OccupancyGrid& grid, VoxelState state, double farthest) {
  const Eigen::Vector3i n = grid.geometry().size;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<float> squared(static_cast<std::size_t>(n.x()) * n.y() * n.z());
  std::size_t at = 0;
  for (int x = 0; x < n.x(); ++x) {
    for (int y = 0; y < n.y(); ++y) {
      for (int z = 0; z < n.z(); ++z) squared[at++] = grid.state({x, y, z}) == state ? 0.0f : std::numeric_limits<float>::infinity();
    }
  }
  const int longest = n.maxCoeff();
  std::vector<double> row(longest, kNone), out(longest), from(longest);
  std::vector<int> apex(longest);
  const std::array<std::size_t, 3> stride{static_cast<std::size_t>(n.y()) * n.z(), static_cast<std::size_t>(n.z()), 1};
  for (int axis : {2, 1, 0}) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < n[u]; ++i) {
      for (int j = 0; j < n[v]; ++j) {
        const std::size_t begin = i * stride[u] + j * stride[v];
        for (int k = 0; k < n[axis]; ++k) row[k] = squared[begin + k * stride[axis]];
        envelope(row, n[axis], out, apex, from);
        for (int k = 0; k < n[axis]; ++k) squared[begin + k * stride[axis]] = static_cast<float>(out[k]);
      }
    }
  }
  for (float& d : squared) d = std::min(std::sqrt(d), static_cast<float>(farthest));
  return squared;
}

}  // namespace periplus::voxel
