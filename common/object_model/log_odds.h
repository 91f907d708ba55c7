// The probabilistic way of carving, for depths and poses that may be wrong: no depth map empties a voxel for good, each adds to the log-odds
// of its being occupied (Moravec and Elfes 1985; clamped, with the constants of OctoMap, Hornung et al. 2013). How sharply hits and misses
// part follows from the depth's standard deviation, z^2 sigma_d / (f B), and the pose's. What one map or one view gets wrong the others
// outvote, later too: a voxel that was emptied may come back.
//
//   log-odds < empty_below                                 empty
//   otherwise > known_above, and seen (Evidence)           known
//   otherwise solid >= seen_points (Evidence)              environment
//   otherwise                                              unknown
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/object_model/evidence.h"

namespace periplus::object_model {

// Log-odds of a brick's voxels [1/1024].
using LogOddsBrick = std::array<std::int16_t, voxel::kBrickVoxels>;

class LogOdds {
 public:
  LogOdds() = default;
  explicit LogOdds(const voxel::GridGeometry& geometry) : geometry_(geometry), bricks_(geometry) {}

  // Adds one depth map. `limits` says which pixels are the object's and which a known solid's; `focal_baseline` [px m]: the rig's.
  // The same values for any `simd`.
  void integrate(const DepthMap& map, const PixelLimits& limits, double focal_baseline, const CarvingRule& rule, const CarvingSettings& settings,
                 voxel::Simd simd = voxel::Simd::best);
  // Labels all voxels but those of `environment`, the plane of what was known before the first look. Notes in `changed` as the functions of
  // evidence.h do.
  void label(const std::vector<std::uint64_t>& environment, const CarvingSettings& settings, const Evidence& evidence, voxel::OccupancyGrid& grid,
             voxel::BrickMarks* changed = nullptr) const;

  // Of a voxel inside the grid.
  double at(const Eigen::Vector3i& v) const;
  const voxel::BrickField<LogOddsBrick>& bricks() const { return bricks_; }
  voxel::BrickField<LogOddsBrick>& bricks() { return bricks_; }
  bool operator==(const LogOdds& other) const { return bricks_ == other.bricks_; }

 private:
  voxel::GridGeometry geometry_;
  voxel::BrickField<LogOddsBrick> bricks_;
};

// The map without depths that too few of their neighbours share: at least `support_share` of the depths within two pixels must lie within
// `tolerance` [m] of it. What is dropped has depth and least depth 0.
DepthMap without_outliers(const DepthMap& map, double support_share, double tolerance);

}  // namespace periplus::object_model
