// Truncated signed distance field beside the grid, one sample at each voxel's centre (Curless, Levoy 1996), with colours:
// where the surface lies within the voxels. Distances are along the optical axis, positive before the surface [m].
#pragma once

#include <cstddef>
#include <vector>

#include "common/object_model/carving.h"

namespace periplus::object_model {

struct TsdfSample {
  float distance = 0;              // mean truncated distance [m]
  float weight = 0;                // 0: never seen
  float r = 0, g = 0, b = 0;       // mean colour, 0..255
  float color_weight = 0;
  bool operator==(const TsdfSample&) const = default;
};

class Tsdf {
 public:
  Tsdf() = default;
  explicit Tsdf(const voxel::GridGeometry& geometry);

  // Adds one depth map; `color` (rgb) must fit the map's camera and may be empty. Depths of known solids say only what is
  // free: the table gets no surface.
  void integrate(const DepthMap& map, const PixelLimits& limits, const ImageU8& color, const voxel::GridGeometry& geometry,
                 double truncation);

  // Index as voxel_index().
  const std::vector<TsdfSample>& samples() const { return samples_; }
  std::vector<TsdfSample>& samples() { return samples_; }

 private:
  std::vector<TsdfSample> samples_;
};

}  // namespace periplus::object_model
