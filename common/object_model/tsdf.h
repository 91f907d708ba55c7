// Truncated signed distance field beside the grid, one sample at each voxel's centre (Curless, Levoy 1996), with colours:
// where the surface lies within the voxels. Distances are along the optical axis, positive before the surface [m].
#pragma once

#include <vector>

#include "common/object_model/carving.h"
#include "common/object_model/tsdf_brick.h"
#include "common/voxel/brick_field.h"

namespace periplus::object_model {

class Tsdf {
 public:
  Tsdf() = default;
  explicit Tsdf(const voxel::GridGeometry& geometry) : geometry_(geometry), bricks_(geometry), free_(voxel::brick_count(geometry)) {}

  // Adds one depth map; `color` (rgb) must fit the map's camera and may be empty. Depths of known solids say only what is
  // free: the table gets no surface. A brick that depth maps have shown to be free as a whole, and nothing else, is kept as
  // one sample, other bricks are packed. The same samples for any `simd`.
  void integrate(const DepthMap& map, const PixelLimits& limits, const ImageU8& color, double truncation, voxel::Simd simd = voxel::Simd::best);

  // Of a voxel inside the grid.
  TsdfSample at(const Eigen::Vector3i& v) const;
  void set(const Eigen::Vector3i& v, const TsdfSample& sample);

  const voxel::BrickField<PackedTsdfBrick>& bricks() const { return bricks_; }
  voxel::BrickField<PackedTsdfBrick>& bricks() { return bricks_; }
  // Of the bricks that are not held: the sample of each of their voxels.
  const std::vector<TsdfSample>& free() const { return free_; }
  std::vector<TsdfSample>& free() { return free_; }
  // Equal samples, however they are kept.
  bool operator==(const Tsdf& other) const;

 private:
  // All of a brick's samples; zeros beyond the grid's size.
  void unpack(std::size_t brick, TsdfBrick& samples) const;

  voxel::GridGeometry geometry_;
  voxel::BrickField<PackedTsdfBrick> bricks_;
  std::vector<TsdfSample> free_;
};

}  // namespace periplus::object_model
