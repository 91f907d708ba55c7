// The object as occupancy grid, bit-packed in bricks of 8 x 8 x 8 voxels. Three planes: occupied, known, environment.
//
//   empty        occupied 0
//   unknown      occupied 1, known 0, environment 0   not seen yet, or hidden
//   known        occupied 1, known 1, environment 0   surface of the object that was seen
//   environment  occupied 1, environment 1            belongs to the table or another known solid
//
// Grid frame G: axes along the box, origin at its least corner; voxel (i, j, k) fills [i, i+1) x [j, j+1) x [k, k+1)
// times voxel_size. Layout (shared by every kernel and by the wire): brick index (bx * nby + by) * nbz + bz; within a
// brick eight 64-bit words, word x & 7, bit (y & 7) * 8 + (z & 7). Bits beyond the grid's size are 0.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/geometry/pose.h"

namespace periplus::voxel {

struct GridGeometry {
  Pose X_WG = Pose::Identity();
  double voxel_size = 0.01;                 // [m]
  Eigen::Vector3i size{0, 0, 0};            // voxels along each axis, 1..512

  // The least grid that fills a box of `box_size` [m] with its centre at X_WB; sizes are rounded up, the box is centred.
  static GridGeometry from_box(const Pose& X_WB, const Eigen::Vector3d& box_size, double voxel_size);
  Eigen::Vector3d center_world(const Eigen::Vector3i& voxel) const {
    return X_WG * ((voxel.cast<double>().array() + 0.5) * voxel_size).matrix();
  }
  Eigen::Vector3i bricks() const { return (size.array() + 7) / 8; }
  // (bx, by, bz) of a brick by its index.
  Eigen::Vector3i brick_position(std::size_t brick) const {
    const Eigen::Vector3i nb = bricks();
    const int b = static_cast<int>(brick);
    return {b / (nb.y() * nb.z()), b / nb.z() % nb.y(), b % nb.z()};
  }
  bool contains(const Eigen::Vector3i& v) const {
    return (v.array() >= 0).all() && (v.array() < size.array()).all();
  }
  // Voxel of a world point (may lie outside: check contains()).
  Eigen::Vector3i voxel_of(const Eigen::Vector3d& p_W) const;
  // Throws Error(bad_input): sizes in 1..512, voxel 0.1 mm..1 m, finite rigid pose.
  void check() const;
};

// Of a voxel inside the grid, z fastest: for arrays that hold a value for every voxel.
inline std::size_t voxel_index(const GridGeometry& g, const Eigen::Vector3i& v) {
  return (static_cast<std::size_t>(v.x()) * g.size.y() + v.y()) * g.size.z() + v.z();
}

enum class VoxelState : std::uint8_t { empty = 0, unknown = 1, known = 2, environment = 3 };

struct Counts {
  std::uint64_t unknown = 0, known = 0, empty = 0, environment = 0;
  bool operator==(const Counts&) const = default;
};

// Plane of all voxels of a grid: the bits beyond its size are 0.
std::vector<std::uint64_t> all_voxels(const GridGeometry& geometry);
// Of it the words of one brick.
std::array<std::uint64_t, 8> brick_voxels(const GridGeometry& geometry, std::size_t brick);

class OccupancyGrid {
 public:
  OccupancyGrid() = default;
  // All voxels unknown, revision 0.
  explicit OccupancyGrid(const GridGeometry& geometry);

  const GridGeometry& geometry() const { return geometry_; }
  std::uint32_t revision = 0;

  VoxelState state(const Eigen::Vector3i& v) const;   // empty outside the grid
  void set_state(const Eigen::Vector3i& v, VoxelState s);
  Counts counts() const;

  // Words of the planes: 8 per brick. Writers keep the bits beyond the size at 0.
  const std::vector<std::uint64_t>& occupied() const { return occupied_; }
  const std::vector<std::uint64_t>& known() const { return known_; }
  const std::vector<std::uint64_t>& environment() const { return environment_; }
  std::vector<std::uint64_t>& occupied() { return occupied_; }
  std::vector<std::uint64_t>& known() { return known_; }
  std::vector<std::uint64_t>& environment() { return environment_; }
  // Word index and bit of a voxel inside the grid.
  std::size_t word(const Eigen::Vector3i& v) const {
    const Eigen::Vector3i nb = geometry_.bricks();
    return ((static_cast<std::size_t>(v.x() >> 3) * nb.y() + (v.y() >> 3)) * nb.z() + (v.z() >> 3)) * 8 + (v.x() & 7);
  }
  static std::uint64_t bit(const Eigen::Vector3i& v) { return 1ull << ((v.y() & 7) * 8 + (v.z() & 7)); }

  // Throws Error(bad_size) unless the planes fit the geometry; clears bits beyond the size and contradictions.
  void adopt(std::vector<std::uint64_t> occupied, std::vector<std::uint64_t> known, std::vector<std::uint64_t> environment);

 private:
  GridGeometry geometry_;
  std::vector<std::uint64_t> occupied_, known_, environment_;
};

}  // namespace periplus::voxel
