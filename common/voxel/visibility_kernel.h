// The inner loop of VisibilityScene::evaluate, once per instruction set: plain data in, plain data out. The units that are
// compiled for more than the baseline must share no inline function of a library with the others, since the linker keeps
// one copy of each: hence no Eigen and no standard containers here.
#pragma once

#include <cstdint>

namespace periplus::voxel {

// Eight voxels each way, as bit planes: word x, bit y * 8 + z.
struct VisibilityBrick {
  std::int32_t at[3];                 // in bricks
  std::uint64_t free_face[6][8];      // voxels with that face uncovered; -x +x -y +y -z +z
  std::uint64_t unknown[8], environment[8], watched[8];
};

struct VoxelPixels {
  std::uint32_t voxel = 0;   // linear index, see VisibilityScene::voxel
  std::uint32_t pixels = 0;  // visible ones, > 0
};

// Coverage: strips of 32 columns, each a column of words, one a row; bit = pixel. `rows` words a strip, at least 16 more than
// the image is high, so that 16 rows can be read anywhere.
struct VisibilityKernelInput {
  const VisibilityBrick* bricks;
  const std::int32_t* index;        // brick -> bricks, -1: nothing to see
  const std::uint64_t* occupied_row;  // [bx * count[1] + by], bit bz: index has it
  std::int32_t count[3];            // bricks along each axis
  std::int32_t size[3];             // voxels along each axis, for the linear index
  // Outward orders along each axis: bricks, and side of the camera for each voxel (0 below, 1 within, 2 above).
  const std::int32_t* brick_order[3];
  const std::int8_t* side[3];
  // Eight voxels of each brick in outward order, by axis: [brick * 8 + i].
  const std::int8_t* cell_order[3];
  float m[3][4];                    // (u w, v w, w) of a point of the grid frame [voxels]; w in metres
  float step[3][8];                 // of corner c (bits x, y, z) from corner 0
  float near;                       // what is nearer to the camera's plane is cut off [m]
  float depth_min, depth_max;       // of a voxel's centre along the optical axis: others occlude, but are neither listed nor summed [m]
  std::uint32_t more_than_pixels;   // voxels with fewer visible pixels are summed but not listed
  std::int32_t width, height, rows;
  std::uint32_t* coverage;
  // Silhouettes of a voxel by 9 side_x + 3 side_y + side_z: corners in turn, counter-clockwise as seen.
  const std::int32_t (*corners)[6];
  const std::int32_t* corner_count;
  // Fills the voxel at (x, y, z), part of which is nearer than `near`, and counts its visible pixels.
  std::uint32_t (*fill_near)(void* context, int x, int y, int z);
  void* context;
};

struct VisibilityKernelOutput {
  VoxelPixels *unknown, *watched;   // with room for every voxel with a free face
  std::uint32_t unknown_count, watched_count;
  std::uint64_t unknown_pixels, known_pixels, environment_pixels;
};

using VisibilityKernel = void (*)(const VisibilityKernelInput&, VisibilityKernelOutput&);

// The same bits from each. Only where the processor has what they need: AVX2; AVX-512 F, BW, DQ, VL and VPOPCNTDQ.
void visibility_kernel_portable(const VisibilityKernelInput& input, VisibilityKernelOutput& output);
void visibility_kernel_avx2(const VisibilityKernelInput& input, VisibilityKernelOutput& output);
void visibility_kernel_avx512(const VisibilityKernelInput& input, VisibilityKernelOutput& output);

}  // namespace periplus::voxel
