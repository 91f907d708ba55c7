#include "integration-tests/eyes_benchmark/label_measures.h"

#include <algorithm>
#include <string>

#include "common/core/error.h"
#include "common/object_model/testing/exact_visibility.h"
#include "integration-tests/eyes_benchmark/voxel_truth.h"

namespace periplus::eyes_benchmark {
namespace {

constexpr int kPlainly = 10;  // pixels

object_model::DepthMap true_depth(const Shot& shot, const EyeTruth& eye) { return {shot.pair.rig.camera, eye.X_WC, eye.depth, {}, {}}; }

}  // namespace

std::vector<std::uint8_t> reached_voxels(const std::vector<Shot>& shots, const voxel::GridGeometry& geometry) {
  std::vector<std::uint8_t> reached(static_cast<std::size_t>(geometry.size.prod()), 0);
  for (const Shot& shot : shots)
    for (const EyeTruth* eye : {&shot.left, &shot.right}) object_model::testing::mark_reached(true_depth(shot, *eye), geometry, reached);
  return reached;
}

LabelQuality label_quality(const voxel::OccupancyGrid& grid, const std::vector<std::uint8_t>& reached, const mesh::TriangleTree& object_W,
                           const std::vector<Shot>& shots, const std::vector<object_model::Perception>& perceptions) {
  const voxel::GridGeometry& g = grid.geometry();
  require(reached.size() == static_cast<std::size_t>(g.size.prod()), ErrorCode::bad_size, "the reached voxels must be those of the grid");
  std::vector<std::uint8_t> plainly(reached.size(), 0);
  for (const object_model::Perception& p : perceptions) {
    const Shot& shot = shots.at(std::stoul(p.view_id.substr(p.view_id.rfind('-') + 1)));
    for (std::size_t e = 0; e < p.depth.size(); ++e) {
      const EyeTruth& eye = e == 0 ? shot.left : shot.right;
      object_model::DepthMap truth = true_depth(shot, eye);
      for (std::size_t i = 0; i < truth.depth.data.size(); ++i)
        if (eye.object.data[i] == 0) truth.depth.data[i] = 0;
      const std::vector<int> pixels = object_model::testing::plain_pixels(truth, p.depth[e].depth, g);
      for (std::size_t i = 0; i < pixels.size(); ++i) plainly[i] |= static_cast<std::uint8_t>(pixels[i] >= kPlainly);
    }
  }
  const auto seen_between_pixels = [&](const Eigen::Vector3i& v) {
    return std::any_of(shots.begin(), shots.end(), [&](const Shot& shot) {
      return object_model::testing::sees_within(g, v, object_W, shot.pair.rig.camera, shot.left.X_WC) ||
             object_model::testing::sees_within(g, v, object_W, shot.pair.rig.camera, shot.right.X_WC);
    });
  };
  LabelQuality q;
  for_each_voxel(grid, [&](const Eigen::Vector3i& v, std::size_t i, voxel::VoxelState state) {
    q.known += state == voxel::VoxelState::known;
    q.known_hidden += state == voxel::VoxelState::known && !reached[i] && !seen_between_pixels(v);
    q.plain += plainly[i];
    q.plain_unknown += plainly[i] && state == voxel::VoxelState::unknown;
    q.plain_emptied += plainly[i] && state == voxel::VoxelState::empty;
  });
  return q;
}

}  // namespace periplus::eyes_benchmark
