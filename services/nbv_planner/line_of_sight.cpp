#include "services/nbv_planner/line_of_sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace periplus::nbv {

bool in_sight(const Situation& s, const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB) {
  if (s.collision->first_hit(p_WA, p_WB)) return false;
  // Voxel by voxel along the way (Amanatides and Woo 1987), in grid coordinates [voxels].
  const voxel::GridGeometry& g = s.grid->geometry();
  const Pose X_GW = g.X_WG.inverse();
  const Eigen::Vector3d a = X_GW * p_WA / g.voxel_size, d = X_GW * p_WB / g.voxel_size - a;
  double in = 0, out = 1;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(d[i]) < 1e-12) {
      if (a[i] < 0 || a[i] >= g.size[i]) return true;
      continue;
    }
    const double t0 = -a[i] / d[i], t1 = (g.size[i] - a[i]) / d[i];
    in = std::max(in, std::min(t0, t1));
    out = std::min(out, std::max(t0, t1));
  }
  if (in >= out) return true;
  const Eigen::Vector3d first = a + (in + 1e-12) * d;
  Eigen::Vector3i v;
  Eigen::Vector3d next, step;
  for (int i = 0; i < 3; ++i) {
    v[i] = std::clamp(static_cast<int>(std::floor(first[i])), 0, g.size[i] - 1);
    step[i] = d[i] == 0 ? std::numeric_limits<double>::infinity() : 1 / std::abs(d[i]);
    next[i] = d[i] == 0 ? std::numeric_limits<double>::infinity() : (v[i] + (d[i] > 0) - a[i]) / d[i];
  }
  while (g.contains(v)) {
    if (s.grid->state(v) != voxel::VoxelState::empty) return false;
    int axis = 0;
    const double t = next.minCoeff(&axis);
    if (t > out) return true;
    v[axis] += d[axis] > 0 ? 1 : -1;
    next[axis] += step[axis];
  }
  return true;
}

}  // namespace periplus::nbv
