// Carving over random scenes, against what is true there.
#include <gtest/gtest.h>

#include "common/object_model/testing/naive_carving.h"
#include "common/object_model/testing/random_scene.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model {
namespace {

using namespace testing;

// Margin of half a diagonal: nothing that belongs to the object is emptied, not a corner of it.
TEST(CarvingProperty, HalfADiagonalEmptiesNoVoxelThatTheObjectTouches) {
  std::size_t touched = 0, touched_emptied = 0, inside = 0, emptied = 0;
  for (int number = 0; number < scene_count(); ++number) {
    const RandomScene s(number);
    ASSERT_TRUE(s.solids.all_closed());
    const voxel::OccupancyGrid carved = s.carved(CarvingSettings{}.margin_voxels);
    const std::vector<std::uint64_t> surface = surface_voxels(s.solids.mesh_W(), s.geometry());
    for_each_voxel(s.geometry(), [&](const Eigen::Vector3i& v) {
      const bool touches = in_plane(carved, surface, v), full = !touches && s.solids.contains(s.geometry().center_world(v));
      const bool empty = carved.state(v) == voxel::VoxelState::empty;
      touched += touches;
      inside += full;
      emptied += empty;
      touched_emptied += empty && (touches || full);
      EXPECT_FALSE(empty && (touches || full)) << "scene " << number << ", voxel " << v.transpose();
    });
  }
  RecordProperty("touched", std::to_string(touched));
  RecordProperty("touched_emptied", std::to_string(touched_emptied));
  const auto scenes = static_cast<std::size_t>(scene_count());
  EXPECT_GT(touched, 500 * scenes);
  EXPECT_GT(inside, 20 * scenes);
  EXPECT_GT(emptied, 5000 * scenes);
}

// Algorithm 3's margin: the object fills no emptied voxel by more than half. In fact by no more than the corner that lies deeper than the
// margin, some 5 %.
TEST(CarvingProperty, HalfAVoxelEmptiesNoneThatTheObjectFillsMoreThanHalf) {
  std::size_t touched_and_emptied = 0;
  double most = 0;
  for (int number = 0; number < scene_count(); ++number) {
    const RandomScene s(number);
    const voxel::OccupancyGrid carved = s.carved(0.5);
    const std::vector<std::uint64_t> surface = surface_voxels(s.solids.mesh_W(), s.geometry());
    for_each_voxel(s.geometry(), [&](const Eigen::Vector3i& v) {
      if (carved.state(v) != voxel::VoxelState::empty) return;
      if (!in_plane(carved, surface, v)) {
        EXPECT_FALSE(s.solids.contains(s.geometry().center_world(v))) << "scene " << number << ", voxel " << v.transpose();
        return;
      }
      ++touched_and_emptied;
      const double filled = filled_share_at_most(s.solids, s.geometry(), v);
      most = std::max(most, filled);
      EXPECT_LE(filled, 0.5) << "scene " << number << ", voxel " << v.transpose();
    });
  }
  RecordProperty("touched_and_emptied", std::to_string(touched_and_emptied));
  RecordProperty("most_filled", std::to_string(most));
  EXPECT_GT(touched_and_emptied, 10 * static_cast<std::size_t>(scene_count()));  // else this shows nothing
}

// Of all voxels, and of those that lie within two voxels of what they could not be emptied for.
TEST(CarvingProperty, TheFastMethodEmptiesAlmostAllThatTheNaiveOneDoesAndNothingElse) {
  for (const double margin : {CarvingSettings{}.margin_voxels, 0.5}) {
    std::size_t naive = 0, fast = 0, naive_near = 0, fast_near = 0;
    for (int number = 0; number < scene_count(); ++number) {
      const RandomScene s(number);
      for (const DepthMap& map : s.maps) {
        const ImageF limit = s.limits(map).limit;
        const auto plane = seen_through(s.grid, map.camera, map.X_WC, limit, margin);
        for_each_voxel(s.geometry(), [&](const Eigen::Vector3i& v) {
          const bool by_naive = naive_empty(s.geometry(), v, map.camera, map.X_WC, limit, margin), by_fast = in_plane(s.grid, plane, v);
          EXPECT_LE(by_fast, by_naive) << "scene " << number << ", voxel " << v.transpose();
          if (!by_naive) return;
          const bool near = !naive_empty(s.geometry(), v, map.camera, map.X_WC, limit, margin + 2);
          ++naive;
          fast += by_fast;
          naive_near += near;
          fast_near += near && by_fast;
        });
      }
    }
    const double share = static_cast<double>(fast) / static_cast<double>(naive), share_near = static_cast<double>(fast_near) / static_cast<double>(naive_near);
    RecordProperty(margin == 0.5 ? "half_voxel_share" : "half_diagonal_share", std::to_string(share));
    RecordProperty(margin == 0.5 ? "half_voxel_share_near" : "half_diagonal_share_near", std::to_string(share_near));
    EXPECT_GE(share, 0.97);
    EXPECT_GE(share_near, 0.97);
    EXPECT_GT(naive_near, 200 * static_cast<std::size_t>(scene_count()));
  }
}

}  // namespace
}  // namespace periplus::object_model
