// Depth maps as a model keeps them: to a tenth of a millimetre, in 16 bits. What is carved goes through this form first, so that
// carving again from what is stored empties the very same voxels.
#pragma once

#include <cstdint>

#include "common/object_model/perception.h"

namespace periplus::object_model {

struct StoredDepth {
  Pinhole camera;
  Pose X_CM = Pose::Identity();   // the map's camera in the left eye
  Image<std::uint16_t> depth;     // nearest [0.1 mm]; 0 where there is none, 65535 from 6.5535 m on
  Image<std::uint16_t> minimum;   // least depth within the pixel's footprint, rounded down; empty if it was not kept
  // Standard deviation of a depth z: sigma_per_z2 z^2 [1/m], the median of the map's pixels; 0..1. 0: exact, or not kept.
  double sigma_per_z2 = 0;
};

// `X_WC`: left eye. The map must be finite and fit its camera.
StoredDepth store_depth(const DepthMap& map, const Pose& X_WC);
// Without a minimum the map may not carve: its limits are zero. Without standard deviations depth_sigma is empty.
DepthMap restore_depth(const StoredDepth& stored, const Pose& X_WC);

}  // namespace periplus::object_model
