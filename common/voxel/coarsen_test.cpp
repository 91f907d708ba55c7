#include "common/voxel/coarsen.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace periplus::voxel {
namespace {

// State of a coarse voxel, counted one by one.
VoxelState counted(const OccupancyGrid& fine, const Eigen::Vector3i& v) {
  int occupied = 0, environment = 0, unknown = 0;
  for (int c = 0; c < 8; ++c) {
    const VoxelState s = fine.state(2 * v + Eigen::Vector3i(c & 1, c >> 1 & 1, c >> 2 & 1));
    occupied += s != VoxelState::empty;
    environment += s == VoxelState::environment;
    unknown += s == VoxelState::unknown;
  }
  if (occupied < 4) return VoxelState::empty;
  if (2 * environment >= occupied) return VoxelState::environment;
  return 2 * unknown >= occupied ? VoxelState::unknown : VoxelState::known;
}

TEST(Coarsen, EachVoxelIsWhatItsEightSay) {
  Random random(5);
  for (const Eigen::Vector3i& size : {Eigen::Vector3i(16, 16, 16), Eigen::Vector3i(21, 9, 34), Eigen::Vector3i(1, 7, 8)}) {
    GridGeometry g;
    g.X_WG = Pose(Eigen::Translation3d(1, 2, 3));
    g.voxel_size = 0.02;
    g.size = size;
    OccupancyGrid grid(g);
    grid.revision = 7;
    for (int x = 0; x < size.x(); ++x) {
      for (int y = 0; y < size.y(); ++y) {
        for (int z = 0; z < size.z(); ++z) grid.set_state({x, y, z}, static_cast<VoxelState>(random.below(4)));
      }
    }
    const OccupancyGrid coarse = coarsen(grid);
    EXPECT_EQ(coarse.revision, 7u);
    EXPECT_EQ(coarse.geometry().size, Eigen::Vector3i((size.array() + 1) / 2));
    EXPECT_EQ(coarse.geometry().voxel_size, 0.04);
    EXPECT_TRUE(coarse.geometry().X_WG.isApprox(g.X_WG));
    Counts counts;
    for (int x = 0; x < coarse.geometry().size.x(); ++x) {
      for (int y = 0; y < coarse.geometry().size.y(); ++y) {
        for (int z = 0; z < coarse.geometry().size.z(); ++z) {
          const VoxelState s = counted(grid, {x, y, z});
          ASSERT_EQ(coarse.state({x, y, z}), s) << x << " " << y << " " << z;
          ++(s == VoxelState::empty ? counts.empty : s == VoxelState::unknown ? counts.unknown : s == VoxelState::known ? counts.known : counts.environment);
        }
      }
    }
    EXPECT_EQ(coarse.counts(), counts);  // no bits beyond the size
  }
}

TEST(Coarsen, ASheetOneVoxelThickStays) {
  GridGeometry g;
  g.size = {16, 16, 16};
  OccupancyGrid grid(g);
  for (int x = 0; x < 16; ++x) {
    for (int y = 0; y < 16; ++y) {
      for (int z = 0; z < 16; ++z) grid.set_state({x, y, z}, x == 5 ? VoxelState::known : VoxelState::empty);
    }
  }
  EXPECT_EQ(coarsen(grid).counts(), (Counts{0, 64, 448, 0}));
}

}  // namespace
}  // namespace periplus::voxel
