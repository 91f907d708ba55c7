// What a depth map says of sixty-four voxels being occupied, once per instruction set. Plain data in, plain data out; no operation is fused
// or reordered, so that all give the same bits.
#pragma once

#include <cstdint>

#include "common/object_model/carving_kernel.h"

namespace periplus::object_model {

struct DepthEvidence {
  const float* surface = nullptr;  // depth of the object's surface, row by row [m]; 0 where there is none
  const float* free = nullptr;     // depth up to which a ray passes through free space [m]; 0 where unknown
  float focal_px = 0, voxel_m = 0;
  float margin_m = 0;              // this close to the surface a voxel is hit; this far before it, it is missed
  float sigma_per_z2 = 0;          // standard deviation of a depth is this times its square [1/m]
  float pose_variance = 0;         // of where the pose puts it [m^2]
  float hit = 0, miss = 0;         // log-odds of one depth map
};

// Mean over nine places of each voxel's projection; 0 where the centre is behind the camera or beside the image.
void layer_log_odds(const GridCamera& camera, const DepthEvidence& map, int x, int y0, int z0, float* out, voxel::Simd simd);

}  // namespace periplus::object_model
