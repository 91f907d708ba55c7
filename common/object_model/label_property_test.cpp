// Labels over random scenes, against exact visibility: known is what a view sees, and what a view sees well is known.
#include <gtest/gtest.h>

#include "common/object_model/testing/exact_visibility.h"
#include "common/object_model/testing/random_scene.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model {
namespace {

using namespace testing;

TEST(LabelProperty, KnownIsWhatAViewSees) {
  constexpr int kPlainly = 10;  // pixels
  const CarvingSettings settings;
  std::size_t known = 0, hidden = 0, plain = 0;
  for (int number = 0; number < scene_count(); ++number) {
    const RandomScene s(number, {320, 240, 0.3, 0.45});
    const voxel::GridGeometry& g = s.geometry();
    voxel::OccupancyGrid grid = s.carved(settings.margin_voxels);
    Evidence evidence(g);
    std::vector<std::uint8_t> reached(static_cast<std::size_t>(g.size.prod()), 0), plainly = reached;
    for (const DepthMap& map : s.maps) {
      add_points(map, s.limits(map), g, settings.margin_voxels, evidence);
      mark_reached(map, g, reached);
      const std::vector<int> pixels = plain_pixels(map, map.depth, g);
      for (std::size_t i = 0; i < pixels.size(); ++i) plainly[i] |= pixels[i] >= kPlainly;
    }
    label(std::vector<std::uint64_t>(grid.occupied().size(), 0), settings, evidence, grid);
    const mesh::TriangleTree tree(s.solids.mesh_W());
    for_each_voxel(g, [&](const Eigen::Vector3i& v) {
      const std::size_t i = voxel::voxel_index(g, v);
      const bool is_known = grid.state(v) == voxel::VoxelState::known;
      known += is_known;
      plain += plainly[i];
      EXPECT_TRUE(!plainly[i] || is_known) << "scene " << number << ", voxel " << v.transpose() << " is seen plainly and not known";
      const auto seen = [&](const DepthMap& map) { return sees_within(g, v, tree, map.camera, map.X_WC); };
      hidden += is_known && !reached[i] && std::none_of(s.maps.begin(), s.maps.end(), seen);
    });
  }
  const double hidden_share = static_cast<double>(hidden) / static_cast<double>(known);
  RecordProperty("hidden_share", std::to_string(hidden_share));
  RecordProperty("seen_plainly", std::to_string(plain));
  EXPECT_LE(hidden_share, 0.001);
  EXPECT_GT(plain, 200 * static_cast<std::size_t>(scene_count()));
}

}  // namespace
}  // namespace periplus::object_model
