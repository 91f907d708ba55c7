#include "common/voxel/occupancy_grid.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::voxel {
namespace {

GridGeometry geometry(int nx, int ny, int nz, double voxel = 0.01) {
  GridGeometry g;
  g.voxel_size = voxel;
  g.size = {nx, ny, nz};
  return g;
}

TEST(GridGeometry, BoxIsFilledAndCentred) {
  const Pose X_WB = make_pose({1, 2, 3}, rotation_from_yaw_pitch_roll(0.3, 0, 0));
  const GridGeometry g = GridGeometry::from_box(X_WB, {0.60, 0.555, 0.5}, 0.01);
  EXPECT_EQ(g.size, Eigen::Vector3i(60, 56, 50));
  const Eigen::Vector3d middle = g.X_WG * Eigen::Vector3d(0.30, 0.28, 0.25);
  EXPECT_LT((middle - X_WB.translation()).norm(), 1e-12);
  EXPECT_LT((g.X_WG.linear() - X_WB.linear()).norm(), 1e-12);
}

TEST(GridGeometry, VoxelOfIsTheInverseOfCenter) {
  const GridGeometry g = GridGeometry::from_box(make_pose({0.2, -1, 0.9}, rotation_from_yaw_pitch_roll(1, 0.2, -0.1)), {0.3, 0.2, 0.1}, 0.02);
  Random random(1);
  for (int n = 0; n < 200; ++n) {
    const Eigen::Vector3i v(static_cast<int>(random.below(40)) - 10, static_cast<int>(random.below(40)) - 10,
                            static_cast<int>(random.below(40)) - 10);
    EXPECT_EQ(g.voxel_of(g.center_world(v)), v);
  }
  EXPECT_FALSE(g.contains(g.voxel_of({1e30, 0, 0})));
}

TEST(GridGeometry, RefusesWhatCannotBeAGrid) {
  EXPECT_THROW(GridGeometry::from_box(Pose::Identity(), {6, 1, 1}, 0.01), Error);
  EXPECT_THROW(GridGeometry::from_box(Pose::Identity(), {0.1, 0, 0.1}, 0.01), Error);
  EXPECT_THROW(GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, 0), Error);
  EXPECT_THROW(GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, std::numeric_limits<double>::quiet_NaN()), Error);
  GridGeometry g = geometry(8, 8, 8);
  g.X_WG.translation().x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(g.check(), Error);
  g = geometry(8, 8, 8);
  g.X_WG.linear() *= 2;
  EXPECT_THROW(g.check(), Error);
  EXPECT_THROW(OccupancyGrid(geometry(513, 8, 8)), Error);
}

TEST(OccupancyGrid, BeginsUnknownEverywhereInside) {
  for (const Eigen::Vector3i& size : {Eigen::Vector3i(8, 8, 8), Eigen::Vector3i(13, 7, 17), Eigen::Vector3i(1, 1, 1)}) {
    const OccupancyGrid grid(geometry(size.x(), size.y(), size.z()));
    EXPECT_EQ(grid.counts().unknown, static_cast<std::uint64_t>(size.prod()));
    EXPECT_EQ(grid.counts().empty, 0u);
    EXPECT_EQ(grid.state({size.x() - 1, size.y() - 1, size.z() - 1}), VoxelState::unknown);
    EXPECT_EQ(grid.state({size.x(), 0, 0}), VoxelState::empty);
    EXPECT_EQ(grid.state({0, -1, 0}), VoxelState::empty);
  }
}

TEST(OccupancyGrid, LayoutIsTheDocumentedOne) {
  OccupancyGrid grid(geometry(20, 20, 20));
  const Eigen::Vector3i v(9, 18, 5);
  EXPECT_EQ(grid.word(v), (((1 * 3 + 2) * 3 + 0) * 8u + 1));
  EXPECT_EQ(OccupancyGrid::bit(v), 1ull << (2 * 8 + 5));
  grid.set_state(v, VoxelState::known);
  EXPECT_EQ(grid.known()[grid.word(v)], OccupancyGrid::bit(v));
}

TEST(OccupancyGrid, StatesAndCountsAgreeWithAMap) {
  OccupancyGrid grid(geometry(11, 9, 10));
  std::map<VoxelState, std::uint64_t> count;
  Random random(7);
  for (int x = 0; x < 11; ++x)
    for (int y = 0; y < 9; ++y)
      for (int z = 0; z < 10; ++z) {
        const auto s = static_cast<VoxelState>(random.below(4));
        grid.set_state({x, y, z}, static_cast<VoxelState>(random.below(4)));
        grid.set_state({x, y, z}, s);
        EXPECT_EQ(grid.state({x, y, z}), s);
        ++count[s];
      }
  EXPECT_EQ(grid.counts(), (Counts{count[VoxelState::unknown], count[VoxelState::known], count[VoxelState::empty], count[VoxelState::environment]}));
  EXPECT_THROW(grid.set_state({11, 0, 0}, VoxelState::known), Error);
}

TEST(OccupancyGrid, AdoptsOnlyPlanesThatFitAndMendsThem) {
  OccupancyGrid grid(geometry(5, 5, 5));
  EXPECT_THROW(grid.adopt({1, 2}, {1, 2}, {1, 2}), Error);
  const std::vector<std::uint64_t> ones(8, ~0ull);
  std::vector<std::uint64_t> occupied(8, ~0ull);
  occupied[0] = 0;
  grid.adopt(occupied, ones, ones);
  EXPECT_EQ(grid.counts(), (Counts{0, 0, 25, 100}));
  EXPECT_EQ(grid.known(), std::vector<std::uint64_t>(8, 0));
  EXPECT_EQ(grid.occupied()[5], 0u);
}

}  // namespace
}  // namespace periplus::voxel
