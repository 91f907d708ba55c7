#include "services/nbv_planner/quality.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace periplus::nbv {
namespace {

constexpr int kAround = 2;  // of the neighbourhood that gives a normal [voxels]

}  // namespace

std::vector<SurfaceVoxel> known_surface(const voxel::OccupancyGrid& grid) {
  const voxel::GridGeometry& g = grid.geometry();
  const Eigen::Vector3i bricks = g.bricks();
  std::vector<SurfaceVoxel> surface;
  std::size_t word = 0;
  for (int bx = 0; bx < bricks.x(); ++bx) {
    for (int by = 0; by < bricks.y(); ++by) {
      for (int bz = 0; bz < bricks.z(); ++bz) {
        for (int x = 0; x < 8; ++x, ++word) {
          for (std::uint64_t known = grid.known()[word]; known != 0; known &= known - 1) {
            const int bit = std::countr_zero(known);
            const Eigen::Vector3i v(bx * 8 + x, by * 8 + (bit >> 3), bz * 8 + (bit & 7));
            bool free = false;
            for (int k = 0; k < 6 && !free; ++k) {
              Eigen::Vector3i n = v;
              n[k / 2] += k % 2 == 0 ? -1 : 1;
              free = grid.state(n) == voxel::VoxelState::empty;
            }
            if (!free) continue;
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            for (int i = -kAround; i <= kAround; ++i) {
              for (int j = -kAround; j <= kAround; ++j) {
                for (int k = -kAround; k <= kAround; ++k) {
                  if (grid.state(v + Eigen::Vector3i(i, j, k)) != voxel::VoxelState::empty) sum -= Eigen::Vector3d(i, j, k);
                }
              }
            }
            SurfaceVoxel s;
            s.voxel = (static_cast<std::uint32_t>(v.x()) * g.size.y() + v.y()) * g.size.z() + v.z();
            s.p_W = g.center_world(v);
            if (sum.norm() > 1) s.normal_W = g.X_WG.linear() * sum.normalized();
            surface.push_back(s);
          }
        }
      }
    }
  }
  return surface;
}

double look_quality(const SurfaceVoxel& s, const Pose& X_WC, double baseline, double reference_distance) {
  const Eigen::Vector3d eye = X_WC * Eigen::Vector3d(baseline / 2, 0, 0);
  const Eigen::Vector3d d = s.p_W - eye;
  const double z = d.dot(X_WC.linear().col(2));
  if (!(z > 0)) return 0;
  const double cosine = s.normal_W.isZero() ? 1 : std::max(0.0, -s.normal_W.dot(d.normalized()));
  const double nearness = reference_distance / z;
  return cosine * std::min(1.0, nearness * nearness);
}

std::vector<float> quality_so_far(const std::vector<SurfaceVoxel>& surface, const Situation& situation,
                                  const voxel::VisibilityScene& scene, const voxel::PairOptions& options,
                                  double reference_distance) {
  const Eigen::Vector3i& n = scene.geometry().size;
  std::vector<std::int32_t> at(static_cast<std::size_t>(n.x()) * n.y() * n.z(), -1);
  for (std::size_t i = 0; i < surface.size(); ++i) at[surface[i].voxel] = static_cast<std::int32_t>(i);
  std::vector<float> best(surface.size(), 0);
  voxel::VisibilityWorkspace w;
  for (const Pose& X_WC : situation.views) {
    scene.evaluate_pair(X_WC, situation.rig, options, w);
    for_each_watched(w, situation.rig, options.more_than_pixels, [&](std::uint32_t voxel) {
      const std::int32_t i = at[voxel];
      if (i < 0) return;
      const auto q = static_cast<float>(look_quality(surface[static_cast<std::size_t>(i)], X_WC, situation.rig.baseline, reference_distance));
      best[static_cast<std::size_t>(i)] = std::max(best[static_cast<std::size_t>(i)], q);
    });
  }
  return best;
}

}  // namespace periplus::nbv
