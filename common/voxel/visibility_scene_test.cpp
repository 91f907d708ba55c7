#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <set>
#include <utility>

#include "common/core/error.h"
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

void expect_same_entries(const VoxelList& a, const VoxelList& b) {
  const auto same = [](const VoxelPixels& x, const VoxelPixels& y) { return x.voxel == y.voxel && x.pixels == y.pixels; };
  EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end(), same));
}

// What a scene takes over from one of another revision changes nothing of what is seen, nor its order.
TEST(VisibilityScene, MadeFromTheOneBeforeItIsTheOneMadeAnew) {
  Random random(23);
  OccupancyGrid grid = testing::random_grid(random, {50, 34, 41}, 0.9);
  const GridGeometry& g = grid.geometry();
  const std::vector<Eigen::Vector3i> marked = {{3, 4, 5}, {20, 20, 20}, {49, 33, 40}, {25, 0, 9}};
  VisibilityScene before(std::make_shared<const ExposedFaces>(grid));
  std::uint64_t seen = 0;
  for (int step = 0; step < 30; ++step) {
    SCOPED_TRACE(step);
    const Eigen::Vector3i first(random.below(50), random.below(34), random.below(41));
    for (int n = 0; n < 6 * 6 * 6 && step % 5 != 0; ++n) {  // in every fifth step nothing changes
      const Eigen::Vector3i v = first + Eigen::Vector3i(n / 36, n / 6 % 6, n % 6);
      if (g.contains(v)) grid.set_state(v, static_cast<VoxelState>(step % 4));
    }
    const auto faces = std::make_shared<const ExposedFaces>(grid);
    const std::vector<Eigen::Vector3i> watched = step % 3 == 0 ? marked : std::vector<Eigen::Vector3i>();
    const VisibilityScene kept(faces, {}, watched, &before), anew(grid, {}, watched), again(faces, {}, {}, &kept);
    for (const bool unknown_alone : {false, true}) {
      const Pose X_WC = testing::random_view(random, g, 0.5, 1.5);
      const Pinhole camera = Pinhole::from_vertical_fov(220, 160, 0.9);
      ViewOptions options;
      options.unknown_alone = unknown_alone;
      const VisibilityResult a = kept.evaluate(X_WC, camera, options), b = anew.evaluate(X_WC, camera, options), c = again.evaluate(X_WC, camera, options);
      expect_same_entries(a.unknown, b.unknown);
      expect_same_entries(a.watched, b.watched);
      expect_same_entries(c.unknown, b.unknown);
      EXPECT_TRUE(c.watched.empty());
      EXPECT_EQ(a.unknown_pixels, b.unknown_pixels);
      EXPECT_EQ(a.known_pixels, b.known_pixels);
      EXPECT_EQ(a.environment_pixels, b.environment_pixels);
      seen += a.unknown_pixels + a.watched.size();
    }
    EXPECT_EQ(kept.surface(), anew.surface());
    before = again;
  }
  EXPECT_GT(seen, 10000u);
  GridGeometry other = g;
  other.size.x() = 49;
  EXPECT_THROW(VisibilityScene(std::make_shared<const ExposedFaces>(OccupancyGrid(other)), {}, {}, &before), Error);
}

}  // namespace
}  // namespace periplus::voxel
