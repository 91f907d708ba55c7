// The voxels that a ray passes through, in order (Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing",
// Eurographics 1987).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/voxel/occupancy_grid.h"

namespace periplus::voxel {

// Calls visit(voxel, entry, exit) for each voxel of the grid on the ray from `origin` along the unit vector `direction` (both in
// the grid's frame G, metres), nearest first, until visit returns false or the ray leaves the grid or `range` [m]. `entry`
// and `exit` are distances along the ray, 0 where it begins within the voxel. Neighbours on a ray share a face; a ray
// along a face belongs to the voxel on its upper side. Returns false if visit ended it.
template <class Visit>
bool traverse_ray(const GridGeometry& grid, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double range,
                  Visit&& visit) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double side = grid.voxel_size;
  double begin = 0, end = range;
  for (int a = 0; a < 3; ++a) {
    const double upper = grid.size[a] * side;
    if (direction[a] == 0) {
      if (origin[a] < 0 || origin[a] >= upper) return true;
      continue;
    }
    const double t0 = -origin[a] / direction[a], t1 = (upper - origin[a]) / direction[a];
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  }
  if (!(begin < end)) return true;
  Eigen::Vector3i at, step;
  Eigen::Vector3d next, each;  // distance to the next face across each axis, and between two
  for (int a = 0; a < 3; ++a) {
    const double p = (origin[a] + begin * direction[a]) / side;
    at[a] = std::clamp(static_cast<int>(std::floor(p)), 0, grid.size[a] - 1);
    step[a] = direction[a] > 0 ? 1 : direction[a] < 0 ? -1 : 0;
    each[a] = step[a] == 0 ? kNever : side / std::abs(direction[a]);
    next[a] = step[a] == 0 ? kNever : ((at[a] + (step[a] > 0)) * side - origin[a]) / direction[a];
  }
  for (double entry = begin;;) {
    const int axis = next.x() <= next.y() ? (next.x() <= next.z() ? 0 : 2) : (next.y() <= next.z() ? 1 : 2);
    const double exit = std::min(next[axis], end);
    if (exit > entry && !visit(static_cast<const Eigen::Vector3i&>(at), entry, exit)) return false;
    if (next[axis] >= end) return true;
    entry = std::max(entry, exit);
    at[axis] += step[axis];
    if (at[axis] < 0 || at[axis] >= grid.size[axis]) return true;
    next[axis] += each[axis];
  }
}

}  // namespace periplus::voxel
