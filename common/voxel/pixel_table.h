// Pixels by voxel: a hash table whose room stays from call to call. Its memory grows with the voxels that are seen, not with the grid.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/voxel/visibility_kernel.h"

namespace periplus::voxel {

class PixelTable {
 public:
  // Empties it and makes room for `most` entries.
  void clear(std::size_t most) {
    const std::size_t slots = std::bit_ceil(4 * most + 1);
    shift_ = 32 - std::countr_zero(slots);
    slots_.assign(slots, {});
  }
  // Of one that is not there yet; `v.pixels` is above 0.
  void add(VoxelPixels v) { slots_[find(v.voxel)] = v; }
  // 0 where there is none.
  std::uint32_t pixels(std::uint32_t voxel) const { return slots_[find(voxel)].pixels; }
  // Fetches a voxel's slot ahead.
  void prefetch(std::uint32_t voxel) const { __builtin_prefetch(&slots_[slot(voxel)]); }

 private:
  // Fibonacci hashing (Knuth 6.4).
  std::size_t slot(std::uint32_t voxel) const { return static_cast<std::size_t>(std::uint64_t{voxel * 0x9e3779b1u} >> shift_); }
  std::size_t find(std::uint32_t voxel) const {
    std::size_t at = slot(voxel);
    while (slots_[at].pixels != 0 && slots_[at].voxel != voxel) at = (at + 1) & (slots_.size() - 1);
    return at;
  }

  std::vector<VoxelPixels> slots_{1};  // a power of two of them, less than a quarter full; no pixels: free
  int shift_ = 32;
};

}  // namespace periplus::voxel
