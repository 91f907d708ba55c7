#include "integration-tests/eyes_benchmark/model_measures.h"

#include <cmath>

#include "common/core/error.h"
#include "common/object_model/evidence.h"

namespace periplus::eyes_benchmark {

double covered_share(const voxel::OccupancyGrid& grid, const std::vector<Eigen::Vector3d>& points, double reach) {
  const voxel::GridGeometry& g = grid.geometry();
  const int r = static_cast<int>(std::ceil(reach / g.voxel_size));
  std::size_t covered = 0;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3i at = g.voxel_of(p);
    bool near = false;
    for (int x = -r; x <= r && !near; ++x)
      for (int y = -r; y <= r && !near; ++y)
        for (int z = -r; z <= r && !near; ++z) {
          const Eigen::Vector3i v = at + Eigen::Vector3i(x, y, z);
          near = g.contains(v) && grid.state(v) == voxel::VoxelState::known && (g.center_world(v) - p).norm() <= reach;
        }
    covered += near;
  }
  return points.empty() ? 0 : static_cast<double>(covered) / static_cast<double>(points.size());
}

Spread surface_error(const object_model::SurfaceMesh& surface, const mesh::TriangleTree& truth, double floor) {
  std::vector<double> distances;
  for (const Eigen::Vector3f& p : surface.vertices)
    if (p.z() > floor) distances.push_back(truth.closest(p.cast<double>()).distance);
  return spread(std::move(distances));
}

void count_voxels(const voxel::OccupancyGrid& grid, const VoxelTruth& truth, ModelQuality& q) {
  const voxel::GridGeometry& g = grid.geometry();
  require(truth.inside.size() == static_cast<std::size_t>(g.size.cast<std::int64_t>().prod()) && truth.touching.size() == truth.inside.size(), ErrorCode::bad_size,
          "the true voxels must be those of the grid");
  q.inside = q.inside_emptied = q.touching = q.touching_emptied = 0;
  std::size_t ghosts = 0, volume = 0;
  for_each_voxel(grid, [&](const Eigen::Vector3i&, std::size_t i, voxel::VoxelState state) {
    const bool empty = state == voxel::VoxelState::empty;
    q.inside += truth.inside[i];
    q.inside_emptied += truth.inside[i] && empty;
    q.touching += truth.touching[i];
    q.touching_emptied += truth.touching[i] && empty;
    volume += truth.inside[i] || truth.touching[i];
    ghosts += !truth.inside[i] && !truth.touching[i] && !empty && state != voxel::VoxelState::environment;
  });
  q.ghosts = volume == 0 ? 0 : static_cast<double>(ghosts) / static_cast<double>(volume);
}

}  // namespace periplus::eyes_benchmark
