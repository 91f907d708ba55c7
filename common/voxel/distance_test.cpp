#include "common/voxel/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/core/random.h"

namespace periplus::voxel {
namespace {

TEST(Distance, IsTheNearestOfThatState) {
  Random random(7);
  for (double share : {0.3, 0.01, 0.0}) {
    GridGeometry g;
    g.size = {13, 9, 17};
    OccupancyGrid grid(g);
    std::vector<Eigen::Vector3i> known;
    for (int x = 0; x < 13; ++x) {
      for (int y = 0; y < 9; ++y) {
        for (int z = 0; z < 17; ++z) {
          if (random.uniform() >= share) continue;
          grid.set_state({x, y, z}, VoxelState::known);
          known.emplace_back(x, y, z);
        }
      }
    }
    const std::vector<float> distance = distance_to_state(grid, VoxelState::known, 6);
    ASSERT_EQ(distance.size(), 13u * 9 * 17);
    std::size_t at = 0;
    for (int x = 0; x < 13; ++x) {
      for (int y = 0; y < 9; ++y) {
        for (int z = 0; z < 17; ++z) {
          double least = 6;
          for (const auto& v : known) least = std::min(least, (v - Eigen::Vector3i(x, y, z)).cast<double>().norm());
          ASSERT_NEAR(distance[at++], least, 1e-5) << x << ' ' << y << ' ' << z;
        }
      }
    }
  }
}

}  // namespace
}  // namespace periplus::voxel
