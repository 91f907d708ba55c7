#include "services/nbv_planner/likely_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/core/random.h"

namespace periplus::nbv {
namespace {

using voxel::VoxelState;

// Steps by turns across faces, and across faces, edges and corners.
bool reached(Eigen::Vector3i d, int steps) {
  d = d.cwiseAbs();
  const int corner_steps = steps / 2, face_steps = steps - corner_steps;
  return (d.array() - corner_steps).max(0).sum() <= face_steps;
}

TEST(LikelySurface, KeepsTheUnknownNearTheKnown) {
  Random random(11);
  for (const Eigen::Vector3i& size : {Eigen::Vector3i(21, 10, 70), Eigen::Vector3i(9, 33, 130)}) {
    voxel::GridGeometry g;
    g.voxel_size = 0.01;
    g.size = size;
    voxel::OccupancyGrid grid(g);
    std::vector<Eigen::Vector3i> known;
    for (int x = 0; x < size.x(); ++x) {
      for (int y = 0; y < size.y(); ++y) {
        for (int z = 0; z < size.z(); ++z) {
          const double u = random.uniform();
          if (u < 0.002) known.emplace_back(x, y, z);
          grid.set_state({x, y, z}, u < 0.002  ? VoxelState::known
                                    : u < 0.3  ? VoxelState::empty
                                    : u < 0.35 ? VoxelState::environment
                                               : VoxelState::unknown);
        }
      }
    }
    grid.revision = 5;
    for (const int steps : {1, 4, 7}) {
      const voxel::OccupancyGrid likely = likely_surface(grid, steps);
      EXPECT_EQ(likely.revision, 5u);
      int kept = 0, taken = 0;
      for (int x = 0; x < size.x(); ++x) {
        for (int y = 0; y < size.y(); ++y) {
          for (int z = 0; z < size.z(); ++z) {
            const Eigen::Vector3i v(x, y, z);
            const VoxelState was = grid.state(v);
            if (was != VoxelState::unknown) {
              ASSERT_EQ(likely.state(v), was);
              continue;
            }
            const bool near = std::any_of(known.begin(), known.end(), [&](const auto& k) { return reached(k - v, steps); });
            ASSERT_EQ(likely.state(v), near ? VoxelState::unknown : VoxelState::empty) << v.transpose() << ", " << steps << " steps";
            ++(near ? kept : taken);
          }
        }
      }
      EXPECT_GT(kept, 50);
      EXPECT_GT(taken, 50);
    }
  }
}

TEST(LikelySurface, NothingKnownOrNoReachChangesNothing) {
  voxel::GridGeometry g;
  g.size = {9, 9, 9};
  voxel::OccupancyGrid grid(g);
  EXPECT_EQ(likely_surface(grid, 5).counts(), grid.counts());
  grid.set_state({4, 4, 4}, VoxelState::known);
  EXPECT_EQ(likely_surface(grid, 0).counts(), grid.counts());
  EXPECT_EQ(likely_surface(grid, 1).counts().unknown, 6u);
}

}  // namespace
}  // namespace periplus::nbv
