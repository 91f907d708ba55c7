// The faces of a grid's voxels that no occupied voxel covers, in bricks of eight voxels each way: the surface as visibility and a search for
// views read it. Kept from revision to revision: only bricks that have changed, and their six neighbours, are looked at again. A value.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/voxel/brick_field.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::voxel {

// Bit planes of a brick with a free face: word x, bit y * 8 + z.
struct ExposedBrick {
  std::uint32_t brick = 0;                                   // its index in the grid
  std::array<std::array<std::uint64_t, 8>, 6> free_face{};   // voxels with that face uncovered: -x, +x, -y, +y, -z, +z of the grid frame
  std::array<std::uint64_t, 8> unknown{}, environment{};     // all such voxels of the brick, with a free face or without
  // Word `x` of the voxels with any free face.
  std::uint64_t exposed(std::size_t x) const {
    return free_face[0][x] | free_face[1][x] | free_face[2][x] | free_face[3][x] | free_face[4][x] | free_face[5][x];
  }
  bool operator==(const ExposedBrick&) const = default;
};

class ExposedFaces {
 public:
  // Throws Error(bad_input): an impossible geometry.
  explicit ExposedFaces(const OccupancyGrid& grid);

  // As if made anew of `grid`, which differs from that of last time in the marked bricks alone. Throws Error(bad_size): another geometry, or
  // not one mark a brick.
  void update(const OccupancyGrid& grid, const BrickMarks& changed);

  const GridGeometry& geometry() const { return geometry_; }
  // Of the grid, with a free face or without.
  std::size_t brick_count() const { return slots_.size(); }
  // With a free face.
  std::size_t held() const { return bricks_.size(); }
  // Null if the brick has no free face.
  const ExposedBrick* find(std::size_t brick) const { return slots_[brick] == kNone ? nullptr : &bricks_[slots_[brick]]; }
  // Calls visit(const ExposedBrick&) for all that have a free face, in the grid's order.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (const std::uint32_t slot : slots_)
      if (slot != kNone) visit(bricks_[slot]);
  }
  // The same bricks with the same words, however they came about.
  bool operator==(const ExposedFaces& other) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  void look_at(const OccupancyGrid& grid, std::size_t brick, const Eigen::Vector3i& at);

  GridGeometry geometry_;
  std::vector<std::uint32_t> slots_;   // brick -> bricks_
  std::vector<ExposedBrick> bricks_;   // in no order
};

}  // namespace periplus::voxel
