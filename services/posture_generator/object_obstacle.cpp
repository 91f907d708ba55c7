#include "services/posture_generator/object_obstacle.h"

#include <algorithm>
#include <cmath>

namespace periplus::posture {

ObjectObstacle::ObjectObstacle(const voxel::OccupancyGrid& grid, double cell_size) {
  const voxel::GridGeometry& geometry = grid.geometry();
  const int edge = std::max(1, static_cast<int>(std::lround(cell_size / geometry.voxel_size)));
  const Eigen::Vector3i cells = (geometry.size.array() + edge - 1) / edge;
  if ((geometry.size.array() <= 0).any()) return;
  std::vector<char> filled(static_cast<std::size_t>(cells.x()) * cells.y() * cells.z(), 0);
  const auto index = [&](const Eigen::Vector3i& c) { return (static_cast<std::size_t>(c.x()) * cells.y() + c.y()) * cells.z() + c.z(); };
  Eigen::Vector3i v;
  for (v.x() = 0; v.x() < geometry.size.x(); ++v.x()) {
    for (v.y() = 0; v.y() < geometry.size.y(); ++v.y()) {
      for (v.z() = 0; v.z() < geometry.size.z(); ++v.z()) {
        const voxel::VoxelState state = grid.state(v);
        if (state == voxel::VoxelState::unknown || state == voxel::VoxelState::known) filled[index(v / edge)] = 1;
      }
    }
  }
  const auto is_filled = [&](const Eigen::Vector3i& c) {
    return (c.array() >= 0).all() && (c.array() < cells.array()).all() && filled[index(c)] != 0;
  };
  Eigen::Vector3i c;
  for (c.x() = 0; c.x() < cells.x(); ++c.x()) {
    for (c.y() = 0; c.y() < cells.y(); ++c.y()) {
      for (c.z() = 0; c.z() < cells.z(); ++c.z()) {
        if (!is_filled(c)) continue;
        bool surface = false;
        for (int axis = 0; axis < 3 && !surface; ++axis) {
          const Eigen::Vector3i step = Eigen::Vector3i::Unit(axis);
          surface = !is_filled(c + step) || !is_filled(c - step);
        }
        // Capsules are far thicker than a cell: they meet the surface before they are inside.
        if (surface) centers_.push_back(geometry.X_WG * ((c.cast<double>().array() + 0.5) * edge * geometry.voxel_size).matrix());
      }
    }
  }
  radius_ = 0.5 * std::sqrt(3.0) * edge * geometry.voxel_size;
  if (centers_.empty()) return;
  for (const Eigen::Vector3d& p : centers_) middle_ += p;
  middle_ /= static_cast<double>(centers_.size());
  for (const Eigen::Vector3d& p : centers_) reach_ = std::max(reach_, (p - middle_).norm());
}

ObjectObstacle::Nearest ObjectObstacle::nearest(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double range) const {
  Nearest best{range, a, a};
  const Eigen::Vector3d way = b - a;
  const double length2 = std::max(way.squaredNorm(), 1e-18);
  const auto on_axis = [&](const Eigen::Vector3d& p) { return Eigen::Vector3d(a + std::clamp((p - a).dot(way) / length2, 0.0, 1.0) * way); };
  if (centers_.empty() || (on_axis(middle_) - middle_).norm() - reach_ - radius_ >= range) return best;
  double least2 = (range + radius_) * (range + radius_);
  for (const Eigen::Vector3d& p : centers_) {
    const Eigen::Vector3d q = on_axis(p);
    const double d2 = (q - p).squaredNorm();
    if (d2 < least2) {
      least2 = d2;
      best = {std::sqrt(d2) - radius_, q, p};
    }
  }
  return best;
}

}  // namespace periplus::posture
