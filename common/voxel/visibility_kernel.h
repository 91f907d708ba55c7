// The inner loop of VisibilityScene::evaluate, once per instruction set: plain data in, plain data out. The units that are
// compiled for more than the baseline must share no inline function of a library with the others, since the linker keeps
// one copy of each: hence no Eigen and no standard containers here.
#pragma once

#include <cstdint>

namespace periplus::voxel {

// A voxel of the grid in 32 bits: what it is, z, y, x. Of a voxel in its brick the coordinates are 0 to 7; the brick's add to it.
enum : std::uint32_t { kVoxelUnknown = 1, kVoxelEnvironment = 2, kVoxelWatched = 4 };
enum : int { kVoxelZ = 3, kVoxelY = 12, kVoxelX = 22 };  // first bits: 512 voxels along z, 1024 along y and x

// Eight voxels each way, of which some have a free face.
struct VisibilityBrick {
  std::int32_t at[3];          // in bricks
  float middle[3], extent[3];  // box around the voxels with a free face, in the grid [voxels]
  // Voxels with a free face towards an octant of camera positions, outward from it so that no later one hides an earlier one: count[o]
  // from codes[first[o]] on. Bit a of o: the camera is above along axis a.
  std::uint32_t first[8];
  std::uint16_t count[8];
};

struct VoxelPixels {
  std::uint32_t voxel = 0;   // linear index, see VisibilityScene::voxel
  std::uint32_t pixels = 0;  // visible ones, > 0
};

// A piece of a brick along one axis that the camera stands on one side of.
struct BrickPart {
  std::int8_t side;       // of the camera: 0 below, 1 within (one voxel), 2 above
  std::int8_t low, high;  // voxels, inclusive
};

// Bricks of one level do not hide each other; those of a later level hide none of an earlier one.
struct BrickTurn {
  std::int32_t brick, level;
};

// Coverage: strips of 32 columns, each a column of words, one a row; bit = pixel, set: covered. `rows` words a strip, at least 16
// more than the image is high, so that 16 rows can be read anywhere; two strips more than the
// image is wide. All outside of the image is set.
struct VisibilityKernelInput {
  const VisibilityBrick* bricks;
  const std::uint32_t* codes;         // with 16 more to read at the end
  const BrickTurn* turns;             // of all bricks
  std::int32_t turn_count;
  std::int32_t size[3];               // voxels along each axis, for the linear index
  const BrickPart* parts[3];          // [brick * 3], outward; part_count[brick] of them
  const std::int8_t* part_count[3];
  // (u w, v w, w) of a point of the grid frame [voxels]; w in metres, u and v [px] from column `center[0]` and row `center[1]`.
  float m[3][4];
  std::int32_t center[2];
  float near;                         // what is nearer to the camera's plane is cut off [m]
  float depth_min, depth_max;         // of a voxel's centre along the optical axis: others occlude, but are neither listed nor summed [m]
  std::uint32_t more_than_pixels;     // voxels with fewer visible pixels are summed but not listed
  std::int32_t width, height, rows;
  std::uint32_t* coverage;
  // Silhouettes of a voxel by 9 side_x + 3 side_y + side_z: corners in turn, bits 0 x, 1 y, 2 z.
  const std::int32_t (*corners)[6];
  const std::int32_t* corner_count;
  // Fills the voxel at (x, y, z), part of which is nearer than `near`, and counts its visible pixels.
  std::uint32_t (*fill_near)(void* context, int x, int y, int z);
  void* context;
};

struct VisibilityKernelOutput {
  VoxelPixels *unknown, *watched;   // with room for every voxel with a free face and 16 more
  std::uint32_t unknown_count, watched_count;
  std::uint64_t unknown_pixels, known_pixels, environment_pixels;
};

using VisibilityKernel = void (*)(const VisibilityKernelInput&, VisibilityKernelOutput&);

// The same bits from each. Only where the processor has what they need: AVX2; AVX-512 F, BW, DQ and VL; VPOPCNTDQ besides.
void visibility_kernel_portable(const VisibilityKernelInput& input, VisibilityKernelOutput& output);
void visibility_kernel_avx2(const VisibilityKernelInput& input, VisibilityKernelOutput& output);
void visibility_kernel_avx512(const VisibilityKernelInput& input, VisibilityKernelOutput& output);
void visibility_kernel_avx512_popcnt(const VisibilityKernelInput& input, VisibilityKernelOutput& output);

}  // namespace periplus::voxel
