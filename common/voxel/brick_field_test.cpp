#include "common/voxel/brick_field.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace periplus::voxel {
namespace {

using Brick = std::array<int, kBrickVoxels>;

const GridGeometry kGrid = GridGeometry::from_box(Pose::Identity(), {0.20, 0.17, 0.09}, 0.01);

// Every voxel has a place of its own, the one of its bit in the planes.
TEST(BrickField, PlacesOfVoxelsAreThoseOfThePlanes) {
  const OccupancyGrid grid(kGrid);
  std::set<std::size_t> places;
  for (int x = 0; x < kGrid.size.x(); ++x)
    for (int y = 0; y < kGrid.size.y(); ++y)
      for (int z = 0; z < kGrid.size.z(); ++z) {
        const Eigen::Vector3i v(x, y, z);
        const std::size_t brick = brick_of(kGrid, v);
        const auto within = static_cast<std::size_t>(within_brick(v));
        ASSERT_LT(brick, brick_count(kGrid));
        ASSERT_LT(within, static_cast<std::size_t>(kBrickVoxels));
        EXPECT_EQ(grid.word(v), brick * 8 + within / 64);
        EXPECT_EQ(OccupancyGrid::bit(v), 1ull << within % 64);
        EXPECT_TRUE(places.insert(brick * kBrickVoxels + within).second);
      }
}

TEST(BrickField, HoldsWhatIsWrittenAndNothingElse) {
  BrickField<Brick> field(kGrid);
  EXPECT_EQ(field.size(), brick_count(kGrid));
  EXPECT_EQ(field.held(), 0u);
  EXPECT_EQ(field.find(3), nullptr);
  field.hold(3)[7] = 5;
  field.hold(1)[0] = 2;
  EXPECT_EQ(field.hold(3)[7], 5);
  EXPECT_EQ(field.held(), 2u);
  EXPECT_EQ((*field.find(1))[0], 2);
  EXPECT_EQ(field.find(2), nullptr);
}

TEST(BrickField, IsEqualByItsValues) {
  BrickField<Brick> a(kGrid), b(kGrid);
  a.hold(1)[0] = 2;
  a.hold(3)[7] = 5;
  EXPECT_FALSE(a == b);
  b.hold(3)[7] = 5;
  b.hold(1)[0] = 2;
  EXPECT_TRUE(a == b);
  b.hold(4);  // nothing but zeros
  EXPECT_TRUE(a == b);
  b.hold(4)[9] = 1;
  EXPECT_FALSE(a == b);
  EXPECT_FALSE(a == BrickField<Brick>());
}

}  // namespace
}  // namespace periplus::voxel
