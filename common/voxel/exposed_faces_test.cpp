#include "common/voxel/exposed_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/voxel/testing/random_scene.h"

namespace periplus::voxel {
namespace {

// The bricks in which two grids differ.
BrickMarks differing(const OccupancyGrid& a, const OccupancyGrid& b) {
  BrickMarks marks(brick_count(a.geometry()));
  for (std::size_t w = 0; w < a.occupied().size(); ++w)
    if (a.occupied()[w] != b.occupied()[w] || a.known()[w] != b.known()[w] || a.environment()[w] != b.environment()[w]) marks[w / 8] = 1;
  return marks;
}

// Empties or fills a block somewhere, or changes what some voxels are.
void edit(Random& random, OccupancyGrid& grid) {
  const Eigen::Vector3i& size = grid.geometry().size;
  const auto state = static_cast<VoxelState>(random.below(4));
  const auto below = [&](int n) { return static_cast<int>(random.below(static_cast<std::uint32_t>(n))); };
  const Eigen::Vector3i first(below(size.x()), below(size.y()), below(size.z()));
  const Eigen::Vector3i last = (first.array() + random.below(random.below(3) == 0 ? 20 : 3)).min(size.array() - 1);
  for (int x = first.x(); x <= last.x(); ++x)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int z = first.z(); z <= last.z(); ++z) grid.set_state({x, y, z}, state);
}

TEST(ExposedFaces, AreThoseOfEachVoxelsNeighbours) {
  Random random(3);
  for (const Eigen::Vector3i& size : {Eigen::Vector3i(24, 16, 8), Eigen::Vector3i(13, 27, 18), Eigen::Vector3i(1, 9, 31)}) {
    OccupancyGrid grid = testing::random_grid(random, size, 0.6);
    for (int n = 0; n < 20; ++n) edit(random, grid);
    const ExposedFaces faces(grid);
    std::set<std::size_t> with_faces;
    for (int x = 0; x < size.x(); ++x)
      for (int y = 0; y < size.y(); ++y)
        for (int z = 0; z < size.z(); ++z) {
          const Eigen::Vector3i v(x, y, z);
          const std::size_t brick = brick_of(grid.geometry(), v);
          const ExposedBrick* found = faces.find(brick);
          for (std::size_t d = 0; d < 6; ++d) {
            const Eigen::Vector3i next = v + Eigen::Vector3i((d % 2 == 0 ? -1 : 1) * Eigen::Vector3i::Unit(static_cast<int>(d / 2)));
            const bool is_free = grid.state(v) != VoxelState::empty && grid.state(next) == VoxelState::empty;
            EXPECT_EQ(found && (found->free_face[d][x & 7] & OccupancyGrid::bit(v)) != 0, is_free);
            if (is_free) with_faces.insert(brick);
          }
          if (!found) continue;
          EXPECT_EQ((found->unknown[x & 7] & OccupancyGrid::bit(v)) != 0, grid.state(v) == VoxelState::unknown);
          EXPECT_EQ((found->environment[x & 7] & OccupancyGrid::bit(v)) != 0, grid.state(v) == VoxelState::environment);
        }
    EXPECT_EQ(faces.held(), with_faces.size());
    std::vector<std::size_t> in_order;
    faces.for_each([&](const ExposedBrick& b) { in_order.push_back(b.brick); });
    EXPECT_TRUE(std::equal(in_order.begin(), in_order.end(), with_faces.begin(), with_faces.end()));
  }
}

TEST(ExposedFaces, BroughtUpToDateTheyAreThoseMadeAnew) {
  Random random(11);
  std::size_t came = 0, went = 0;
  for (const Eigen::Vector3i& size : {Eigen::Vector3i(64, 40, 24), Eigen::Vector3i(33, 18, 61), Eigen::Vector3i(7, 80, 9)}) {
    GridGeometry g;
    g.size = size;
    OccupancyGrid grid(g);
    ExposedFaces kept(grid);
    for (int step = 0; step < 150; ++step) {
      const OccupancyGrid before = grid;
      const std::size_t held = kept.held();
      for (std::uint32_t n = random.below(4); n > 0; --n) edit(random, grid);
      kept.update(grid, differing(before, grid));
      ASSERT_TRUE(kept == ExposedFaces(grid)) << "step " << step;
      came += kept.held() > held;
      went += kept.held() < held;
    }
  }
  EXPECT_GT(came, 10u);
  EXPECT_GT(went, 10u);
}

// Only what is marked is looked at: a mark that is missed shows.
TEST(ExposedFaces, AMarkThatIsMissedLeavesThemBehind) {
  Random random(5);
  OccupancyGrid grid = testing::random_grid(random, {40, 40, 40}, 0.5);
  const ExposedFaces before(grid);
  grid.set_state({20, 20, 20}, grid.state({20, 20, 20}) == VoxelState::unknown ? VoxelState::known : VoxelState::unknown);
  BrickMarks marks(before.brick_count());
  ExposedFaces kept = before;
  kept.update(grid, marks);
  EXPECT_TRUE(kept == before);
  EXPECT_FALSE(kept == ExposedFaces(grid));
  marks[brick_of(grid.geometry(), {20, 20, 20})] = 1;
  kept.update(grid, marks);
  EXPECT_TRUE(kept == ExposedFaces(grid));
}

// A brick's faces depend on its neighbours: emptying one uncovers the others', filling it covers them again.
TEST(ExposedFaces, TheSixNeighboursOfWhatChangesAreLookedAtToo) {
  GridGeometry g;
  g.size = {40, 40, 40};
  OccupancyGrid grid(g);
  ExposedFaces kept(grid);
  const std::size_t middle = brick_of(g, {20, 20, 20}), beside = brick_of(g, {20, 20, 12});
  EXPECT_EQ(kept.find(beside), nullptr);
  BrickMarks marks(kept.brick_count());
  marks[middle] = 1;
  const auto fill = [&](VoxelState state) {
    for (int n = 0; n < kBrickVoxels; ++n) grid.set_state(Eigen::Vector3i(16 + n / 64, 16 + n / 8 % 8, 16 + n % 8), state);
    kept.update(grid, marks);
  };
  const std::size_t outside = kept.held();
  fill(VoxelState::empty);
  EXPECT_EQ(kept.find(middle), nullptr);
  ASSERT_NE(kept.find(beside), nullptr);
  EXPECT_EQ(kept.find(beside)->free_face[5][4], 0x8080808080808080ull);
  EXPECT_EQ(kept.held(), outside + 6);
  fill(VoxelState::unknown);
  EXPECT_EQ(kept.held(), outside);
  EXPECT_TRUE(kept == ExposedFaces(grid));
}

TEST(ExposedFaces, AnotherGridOrOtherMarksAreRefused) {
  GridGeometry g;
  g.size = {16, 16, 16};
  const OccupancyGrid grid(g);
  ExposedFaces faces(grid);
  const BrickMarks none(faces.brick_count());
  const auto refused = [&](const OccupancyGrid& other, const BrickMarks& marks) {
    try {
      faces.update(other, marks);
    } catch (const Error& e) {
      return e.code() == ErrorCode::bad_size;
    }
    return false;
  };
  EXPECT_FALSE(refused(grid, none));
  EXPECT_TRUE(refused(grid, BrickMarks(none.size() - 1)));
  GridGeometry longer = g, finer = g, moved = g;
  longer.size.z() = 15;
  finer.voxel_size /= 2;
  moved.X_WG.translation().x() += 1;
  for (const GridGeometry& other : {longer, finer, moved}) EXPECT_TRUE(refused(OccupancyGrid(other), none));
}

}  // namespace
}  // namespace periplus::voxel
