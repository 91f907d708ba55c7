// Values for the voxels of a few bricks of a grid: memory grows with the bricks that hold something, not with the grid. Bricks are those of
// OccupancyGrid, 8 x 8 x 8 voxels; within one, voxel (x & 7) * 64 + (y & 7) * 8 + (z & 7), as the planes' words and bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/voxel/occupancy_grid.h"

namespace periplus::voxel {

constexpr int kBrickVoxels = 512;

// One for each brick of a grid, by its index: not 0 where something of the brick has changed.
using BrickMarks = std::vector<std::uint8_t>;

inline std::size_t brick_count(const GridGeometry& g) {
  const Eigen::Vector3i nb = g.bricks();
  return static_cast<std::size_t>(nb.x()) * nb.y() * nb.z();
}
// Of a voxel inside the grid.
inline std::size_t brick_of(const GridGeometry& g, const Eigen::Vector3i& v) {
  const Eigen::Vector3i nb = g.bricks();
  return (static_cast<std::size_t>(v.x() >> 3) * nb.y() + (v.y() >> 3)) * nb.z() + (v.z() >> 3);
}
inline int within_brick(const Eigen::Vector3i& v) { return (v.x() & 7) * 64 + (v.y() & 7) * 8 + (v.z() & 7); }

// `Brick` holds the values of 512 voxels; what no brick holds has the values of Brick{}.
template <class Brick>
class BrickField {
 public:
  BrickField() = default;
  explicit BrickField(const GridGeometry& geometry) : slots_(brick_count(geometry), kNone) {}

  std::size_t size() const { return slots_.size(); }
  std::size_t held() const { return bricks_.size(); }
  // Null where nothing is held.
  const Brick* find(std::size_t brick) const { return slots_[brick] == kNone ? nullptr : &bricks_[slots_[brick]]; }
  Brick* find(std::size_t brick) { return slots_[brick] == kNone ? nullptr : &bricks_[slots_[brick]]; }
  // Made if it is not there. Pointers to other bricks may no longer hold after that.
  Brick& hold(std::size_t brick) {
    if (slots_[brick] == kNone) {
      slots_[brick] = static_cast<std::uint32_t>(bricks_.size());
      bricks_.emplace_back();
    }
    return bricks_[slots_[brick]];
  }
  // Equal values, in whatever order the bricks were made.
  bool operator==(const BrickField& other) const {
    if (size() != other.size()) return false;
    const Brick nothing{};
    for (std::size_t b = 0; b < size(); ++b) {
      const Brick *mine = find(b), *theirs = other.find(b);
      if ((mine || theirs) && !((mine ? *mine : nothing) == (theirs ? *theirs : nothing))) return false;
    }
    return true;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  std::vector<std::uint32_t> slots_;
  std::vector<Brick> bricks_;
};

}  // namespace periplus::voxel
