// Which voxels the depths of one row of pixels speak for, once per instruction set. Plain data in, plain data out; no operation is fused or
// reordered, so that all give the same bits.
#pragma once

#include <cstdint>

#include "common/voxel/visibility.h"

namespace periplus::object_model {

// A depth map's rays in the grid [voxels]: the point of pixel (u, v) at depth z [m] is origin + z (du u + dv v + d1).
struct GridRays {
  float origin[3] = {}, du[3] = {}, dv[3] = {}, d1[3] = {};
  std::int32_t size[3] = {}, bricks[3] = {};
  float voxel_m = 0, focal_px = 0, margin_m = 0;
  const float* minimum = nullptr;  // least depths [m], row by row; 0 where there is none
  std::int32_t width = 0, height = 0;
};

constexpr int kRun = 64;        // pixels at a time
constexpr int kMostSteps = 32;  // along a ray

// A bit for each code that is another than the one before it, the first among them; and for those of these that are a voxel's.
struct RunBits {
  std::uint64_t changes, voxels;
};

// Codes: twice the voxel (512 times its brick and within_brick()), and one more for a known solid; -1 for none.
struct RunVoxels {
  std::int32_t point[kRun];              // the voxel that the depth's point lies in; none for known solids
  std::int32_t step[kMostSteps][kRun];   // those on the ray closely behind and before it, one for each step towards the camera, none twice
  RunBits point_bits, step_bits[kMostSteps];
  int steps;
};

// Pixels x0 .. x0 + kRun - 1 of row y, within the image. `sigma`: standard deviations of the depths, not negative [m]; the steps begin that far
// behind them. `kind`: as PixelKind, 0 for pixels that say nothing.
void run_voxels(const GridRays& rays, int x0, int y, const float* depth, const float* sigma, const std::uint8_t* kind, RunVoxels& out,
                voxel::Simd simd);

}  // namespace periplus::object_model
