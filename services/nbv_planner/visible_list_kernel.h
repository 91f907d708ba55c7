// The loops over lists of points that a search from panoramas spends its time in besides rendering, once per instruction
// set. Plain data in, plain data out; no operation is fused or reordered and sums are of integers, so that all give the same
// bits.
#pragma once

#include <cstdint>

#include "common/voxel/visibility.h"

namespace periplus::nbv {

// Points as arrays, `count` of them, a multiple of 16; those that only fill up weigh nothing.
struct PointArrays {
  const float *x = nullptr, *y = nullptr, *z = nullptr;
  const std::int32_t* weight = nullptr;
  int count = 0;
};

// What both images of a pair contain, about the middle between the eyes.
struct WindowPlanes {
  float right[3] = {}, down[3] = {}, forward[3] = {};  // of the cameras, in the points' axes
  float tan_horizontal = 0, tan_vertical = 0;          // half angles of one eye
  float half_baseline = 0, depth_min = 0, depth_max = 0;  // [m]
};

// Sum of the weights of the points in the window.
std::int32_t window_sum(const PointArrays& points, const WindowPlanes& window, voxel::Simd simd);

// Azimuth [0, 2 pi) about z and elevation (-pi/2 .. pi/2) of each point, times `cells_per_radian`, to 1e-4 rad; the azimuth is
// counted from -x.
void point_angles(const PointArrays& points, float cells_per_radian, float* azimuth, float* elevation, voxel::Simd simd);

// Centres of voxels: `index` as VisibilityScene's, grid of .. x size_y x size_z; p = m (i, j, k, 1).
struct VoxelPlacement {
  std::int32_t size_y = 1, size_z = 1;
  float m[3][4] = {};
};
void place_voxels(const std::uint32_t* index, int count, const VoxelPlacement& placement, float* x, float* y, float* z,
                  voxel::Simd simd);

}  // namespace periplus::nbv
