#include "common/voxel/pixel_table.h"

#include <gtest/gtest.h>

#include <map>

#include "common/core/random.h"

namespace periplus::voxel {
namespace {

TEST(PixelTable, HoldsWhatAMapHolds) {
  Random random(3);
  PixelTable table;
  EXPECT_EQ(table.pixels(7), 0u);
  for (const std::uint64_t range : {std::uint64_t{50}, std::uint64_t{1} << 27, std::uint64_t{1} << 32}) {
    for (const std::size_t most : {std::size_t{0}, std::size_t{1}, std::size_t{40}, std::size_t{5000}}) {
      std::map<std::uint32_t, std::uint32_t> expected;
      table.clear(most);
      for (std::size_t n = 0; n < most; ++n) {
        const VoxelPixels v{static_cast<std::uint32_t>(random.below(range)), 1 + static_cast<std::uint32_t>(random.below(1000))};
        if (expected.emplace(v.voxel, v.pixels).second) table.add(v);
      }
      for (const auto& [voxel, pixels] : expected) EXPECT_EQ(table.pixels(voxel), pixels);
      for (int n = 0; n < 1000; ++n) {
        const auto voxel = static_cast<std::uint32_t>(random.below(range));
        EXPECT_EQ(table.pixels(voxel), expected.contains(voxel) ? expected[voxel] : 0u);
      }
    }
  }
}

}  // namespace
}  // namespace periplus::voxel
