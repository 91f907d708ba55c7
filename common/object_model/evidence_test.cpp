#include "common/object_model/evidence.h"

#include <gtest/gtest.h>

#include <numbers>
#include <system_error>
#include <thread>

#include "common/core/testing/no_threads.h"

namespace periplus::object_model {
namespace {

const CarvingSettings kEvidenceSettings;

// A grid of 20^3 voxels of 1 cm whose middle lies 1 m before a camera that looks along x.
struct WallAhead {
  voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({1, 0, 0}, Eigen::Matrix3d::Identity()), {0.2, 0.2, 0.2}, 0.01);
  voxel::OccupancyGrid grid{g};
  Evidence evidence{g};
  DepthMap map;
  PixelLimits limits;

  explicit WallAhead(float depth, PixelKind kind = PixelKind::surface) {
    map.camera = Pinhole::from_vertical_fov(400, 400, 0.3);
    map.X_WC = look_along({0, 0, 0}, 0, 0);
    map.depth = map.depth_minimum = ImageF(400, 400, 1, depth);
    limits.limit = map.depth;
    limits.kind = Image<PixelKind>(400, 400, 1, kind);
  }
  VoxelEvidence at(int x) const { return evidence.at({x, 10, 10}); }
  void set(int x, std::uint16_t points, std::uint16_t seen, std::uint16_t solid) { evidence.set({x, 10, 10}, {points, seen, solid, 0}); }
  voxel::VoxelState state(int x) const { return grid.state({x, 10, 10}); }
  std::vector<std::uint64_t> plane_of(int x) const {
    std::vector<std::uint64_t> plane(grid.occupied().size(), 0);
    plane[grid.word({x, 10, 10})] |= voxel::OccupancyGrid::bit({x, 10, 10});
    return plane;
  }
  const std::vector<std::uint64_t> nothing = std::vector<std::uint64_t>(grid.occupied().size(), 0);
};

TEST(Evidence, PointsCountWhereTheyFallAndCloselyBefore) {
  WallAhead s(1.005f);  // the middle of voxel 10
  add_points(s.map, s.limits, s.g, kEvidenceSettings.margin_voxels, s.evidence);
  EXPECT_GT(s.at(10).points, 100);  // a voxel is some 13 pixels wide
  EXPECT_EQ(s.at(9).points, 0);
  EXPECT_EQ(s.at(11).points, 0);
  EXPECT_GT(s.at(10).seen, 100);
  EXPECT_GT(s.at(9).seen, 100);  // before the surface by less than the margin
  EXPECT_EQ(s.at(7).seen, 0);
  EXPECT_EQ(s.at(12).seen, 0);
  EXPECT_EQ(s.at(10).solid, 0);
}

// The surface may lie a standard deviation behind its depth, but is never looked for further than half a voxel behind.
TEST(Evidence, VoxelsAreSeenUpToAStandardDeviationBehindTheDepth) {
  for (const auto& [sigma, next_is_seen] : {std::pair{0.0f, false}, {0.0015f, false}, {0.0035f, true}, {0.1f, true}}) {
    WallAhead s(1.0075f);  // a quarter of a voxel before voxel 11
    s.map.depth_sigma = ImageF(400, 400, 1, sigma);
    add_points(s.map, s.limits, s.g, kEvidenceSettings.margin_voxels, s.evidence);
    EXPECT_GT(s.at(10).points, 100);
    EXPECT_EQ(s.at(11).points, 0);
    EXPECT_EQ(s.at(11).seen > 100, next_is_seen) << sigma;
    EXPECT_EQ(s.at(12).seen, 0);
  }
}

// A process may have no thread left: one does the work then.
TEST(Evidence, CarvesAndCountsAlikeWithoutASecondThread) {
  WallAhead two(1.005f), one(1.005f);
  two.grid.set_state({3, 3, 3}, voxel::VoxelState::environment);
  one.grid.set_state({3, 3, 3}, voxel::VoxelState::environment);
  carve_and_count(two.map, two.limits, kEvidenceSettings.margin_voxels, 1, two.grid, two.evidence);
  {
    const NoThreads none;
    ASSERT_THROW(std::thread([] {}).join(), std::system_error);
    carve_and_count(one.map, one.limits, kEvidenceSettings.margin_voxels, 1, one.grid, one.evidence);
  }
  EXPECT_EQ(one.grid.occupied(), two.grid.occupied());
  EXPECT_TRUE(one.evidence == two.evidence);
  EXPECT_EQ(one.state(2), voxel::VoxelState::empty);
}

// A voxel that would project to more than the image, as through a lens of any focal length.
TEST(Evidence, VoxelWiderThanTheImageIsLookedForAtItsEdges) {
  for (const double focal_length : {1e6, 2e11, 1e300}) {
    WallAhead s(1.005f);
    s.map.camera.fx = focal_length;
    add_points(s.map, s.limits, s.g, kEvidenceSettings.margin_voxels, s.evidence);
    EXPECT_GT(s.at(10).points, 0) << focal_length;
  }
}

TEST(Evidence, LabelsFollowTheCounters) {
  WallAhead s(1.005f);
  s.set(5, 3, 0, 0);
  s.set(6, 2, 0, 0);
  s.set(7, 0, 10, 0);
  s.set(8, 0, 9, 0);
  s.set(9, 0, 0, 10);
  s.set(10, 3, 0, 100);
  label(s.nothing, kEvidenceSettings, s.evidence, s.grid);
  EXPECT_EQ(s.state(5), voxel::VoxelState::known);
  EXPECT_EQ(s.state(6), voxel::VoxelState::unknown);
  EXPECT_EQ(s.state(7), voxel::VoxelState::known);
  EXPECT_EQ(s.state(8), voxel::VoxelState::unknown);
  EXPECT_EQ(s.state(9), voxel::VoxelState::environment);
  EXPECT_EQ(s.state(10), voxel::VoxelState::known);  // the object's points outweigh the table's
  EXPECT_EQ(s.grid.counts(), (voxel::Counts{8000 - 4, 3, 0, 1}));
}

TEST(Evidence, KnownSolidsFromTheStartStayEnvironment) {
  WallAhead s(1.005f);
  const auto table = s.plane_of(4);
  s.set(4, 500, 0, 0);
  label(table, kEvidenceSettings, s.evidence, s.grid);
  EXPECT_EQ(s.state(4), voxel::VoxelState::environment);
}

TEST(Evidence, KnownIsNotSticky) {
  WallAhead s(1.005f);
  s.set(5, 30, 0, 0);
  label(s.nothing, kEvidenceSettings, s.evidence, s.grid);
  ASSERT_EQ(s.state(5), voxel::VoxelState::known);
  empty_voxels(s.plane_of(5), 1, s.grid, s.evidence);
  label(s.nothing, kEvidenceSettings, s.evidence, s.grid);
  EXPECT_EQ(s.state(5), voxel::VoxelState::empty);
}

TEST(Evidence, CautiousViewsNeedASecondVote) {
  WallAhead s(1.005f);
  empty_voxels(s.plane_of(5), kEvidenceSettings.cautious_votes, s.grid, s.evidence);
  EXPECT_EQ(s.state(5), voxel::VoxelState::unknown);
  empty_voxels(s.plane_of(6), kEvidenceSettings.cautious_votes, s.grid, s.evidence);
  EXPECT_EQ(s.state(6), voxel::VoxelState::unknown);
  empty_voxels(s.plane_of(5), kEvidenceSettings.cautious_votes, s.grid, s.evidence);
  EXPECT_EQ(s.state(5), voxel::VoxelState::empty);
  empty_voxels(s.plane_of(6), 1, s.grid, s.evidence);
  EXPECT_EQ(s.state(6), voxel::VoxelState::empty);
}

TEST(Evidence, PointsOfKnownSolidsAreNotTheObjects) {
  WallAhead s(1.005f, PixelKind::known_solid);
  add_points(s.map, s.limits, s.g, kEvidenceSettings.margin_voxels, s.evidence);
  EXPECT_EQ(s.at(10).points, 0);
  EXPECT_GT(s.at(10).solid, 100);
  label(s.nothing, kEvidenceSettings, s.evidence, s.grid);
  EXPECT_EQ(s.state(10), voxel::VoxelState::environment);
  EXPECT_EQ(s.state(3), voxel::VoxelState::unknown);
}

}  // namespace
}  // namespace periplus::object_model
