#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <utility>

#include "common/core/random.h"
#include "common/voxel/testing/random_scene.h"
#include "common/voxel/visibility.h"

namespace periplus::voxel {
namespace {

TEST(VisibilityScene, FacesAndSurfaceOfASolidBlock) {
  GridGeometry g;
  g.size = {10, 11, 12};
  const VisibilityScene scene{OccupancyGrid(g)};
  EXPECT_EQ(scene.unknown_face_count(), 2u * (10 * 11 + 11 * 12 + 10 * 12));
  EXPECT_EQ(scene.unknown_faces().size(), scene.unknown_face_count());
  EXPECT_EQ(scene.surface().size(), 10u * 11 * 12 - 8 * 9 * 10);
  for (const auto& f : scene.unknown_faces(7)) {
    const Eigen::Vector3i v = scene.voxel(f.voxel);
    EXPECT_EQ(v[f.direction / 2], f.direction % 2 == 0 ? 0 : g.size[f.direction / 2] - 1);
  }
}

// Voxel by voxel and neighbour by neighbour, over bricks that are whole and bricks that the grid's end cuts.
TEST(VisibilityScene, FacesAndSurfaceAreThoseOfEachVoxelsNeighbours) {
  Random random(17);
  for (const Eigen::Vector3i& size : {Eigen::Vector3i(24, 16, 8), Eigen::Vector3i(13, 27, 18), Eigen::Vector3i(5, 9, 31)}) {
    const OccupancyGrid grid = testing::random_grid(random, size, 0.6);
    const VisibilityScene scene(grid);
    const auto occupied = [&](const Eigen::Vector3i& v) { return grid.geometry().contains(v) && grid.state(v) != VoxelState::empty; };
    std::set<std::uint32_t> surface;
    std::set<std::pair<std::uint32_t, int>> faces;
    for (int x = 0; x < size.x(); ++x)
      for (int y = 0; y < size.y(); ++y)
        for (int z = 0; z < size.z(); ++z) {
          const Eigen::Vector3i v(x, y, z);
          if (!occupied(v)) continue;
          for (int d = 0; d < 6; ++d) {
            if (occupied(v + Eigen::Vector3i((d % 2 == 0 ? -1 : 1) * Eigen::Vector3i::Unit(d / 2)))) continue;
            surface.insert(scene.index(v));
            if (grid.state(v) == VoxelState::unknown) faces.emplace(scene.index(v), d);
          }
        }
    const auto listed = scene.surface();
    EXPECT_EQ(listed.size(), surface.size());
    EXPECT_EQ((std::set<std::uint32_t>(listed.begin(), listed.end())), surface);
    std::set<std::pair<std::uint32_t, int>> unknown;
    for (const auto& f : scene.unknown_faces()) unknown.emplace(f.voxel, f.direction);
    EXPECT_EQ(unknown, faces);
    EXPECT_EQ(scene.unknown_face_count(), faces.size());
    EXPECT_GT(faces.size(), 100u);
  }
}

}  // namespace
}  // namespace periplus::voxel
