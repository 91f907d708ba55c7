#include "common/voxel/occupancy_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "common/core/error.h"
#include "common/geometry/checks.h"

namespace periplus::voxel {

namespace {

constexpr int kMaxSize = 512;

// Bits of a word (one x slice of a brick) that lie inside the grid.
std::uint64_t inside_mask(int y_count, int z_count) {
  const std::uint64_t row = z_count >= 8 ? 0xffull : (1ull << z_count) - 1;
  std::uint64_t mask = 0;
  for (int y = 0; y < std::min(y_count, 8); ++y) mask |= row << (8 * y);
  return mask;
}

// Calls visit(word index, mask of the bits inside the grid) for every word.
template <class Visit>
void for_each_word(const GridGeometry& g, Visit&& visit) {
  const Eigen::Vector3i nb = g.bricks();
  std::size_t word = 0;
  for (int bx = 0; bx < nb.x(); ++bx)
    for (int by = 0; by < nb.y(); ++by)
      for (int bz = 0; bz < nb.z(); ++bz) {
        const std::uint64_t mask = inside_mask(g.size.y() - by * 8, g.size.z() - bz * 8);
        for (int x = 0; x < 8; ++x, ++word) visit(word, bx * 8 + x < g.size.x() ? mask : 0);
      }
}

std::size_t word_count(const GridGeometry& g) {
  const Eigen::Vector3i nb = g.bricks();
  return static_cast<std::size_t>(nb.x()) * nb.y() * nb.z() * 8;
}

}  // namespace

GridGeometry GridGeometry::from_box(const Pose& X_WB, const Eigen::Vector3d& box_size, double voxel_size) {
  require(std::isfinite(voxel_size) && voxel_size >= 1e-4 && voxel_size <= 1, ErrorCode::bad_input,
          "the voxel size must lie between 0.0001 and 1 m");
  require(box_size.allFinite() && (box_size.array() > 0).all() && (box_size.array() <= kMaxSize * voxel_size + 1e-9).all(),
          ErrorCode::bad_input,
          "the box must have positive sides of at most 512 voxels; choose larger voxels or a smaller box");
  GridGeometry g;
  g.voxel_size = voxel_size;
  // The slack keeps 0.6 m / 0.01 m at 60 voxels although the quotient is not exact.
  g.size = (box_size.array() / voxel_size - 1e-6).ceil().cast<int>().max(1);
  g.X_WG = X_WB;
  g.X_WG.translation() = X_WB * Eigen::Vector3d(-0.5 * voxel_size * g.size.cast<double>());
  g.check();
  return g;
}

Eigen::Vector3i GridGeometry::voxel_of(const Eigen::Vector3d& p_W) const {
  const Eigen::Vector3d p = X_WG.linear().transpose() * (p_W - X_WG.translation()) / voxel_size;
  return p.array().floor().max(-1e9).min(1e9).matrix().cast<int>();
}

void GridGeometry::check() const {
  require((size.array() >= 1).all() && (size.array() <= kMaxSize).all(), ErrorCode::bad_input,
          "a grid needs 1 to 512 voxels along each axis; choose another voxel size or box");
  require(std::isfinite(voxel_size) && voxel_size >= 1e-4 && voxel_size <= 1, ErrorCode::bad_input,
          "the voxel size must lie between 0.0001 and 1 m");
  require_rigid(X_WG, "the grid's pose");
}

std::vector<std::uint64_t> all_voxels(const GridGeometry& geometry) {
  std::vector<std::uint64_t> plane(word_count(geometry));
  for_each_word(geometry, [&](std::size_t w, std::uint64_t mask) { plane[w] = mask; });
  return plane;
}

std::array<std::uint64_t, 8> brick_voxels(const GridGeometry& g, std::size_t brick) {
  const Eigen::Vector3i left = g.size - 8 * g.brick_position(brick);
  std::array<std::uint64_t, 8> words{};
  for (int x = 0; x < std::min(8, left.x()); ++x) words[static_cast<std::size_t>(x)] = inside_mask(left.y(), left.z());
  return words;
}

OccupancyGrid::OccupancyGrid(const GridGeometry& geometry) : geometry_(geometry) {
  geometry_.check();
  occupied_ = all_voxels(geometry_);
  known_.assign(occupied_.size(), 0);
  environment_.assign(occupied_.size(), 0);
}

VoxelState OccupancyGrid::state(const Eigen::Vector3i& v) const {
  if (!geometry_.contains(v)) return VoxelState::empty;
  const std::size_t w = word(v);
  const std::uint64_t b = bit(v);
  if (!(occupied_[w] & b)) return VoxelState::empty;
  if (environment_[w] & b) return VoxelState::environment;
  return known_[w] & b ? VoxelState::known : VoxelState::unknown;
}

void OccupancyGrid::set_state(const Eigen::Vector3i& v, VoxelState s) {
  require(geometry_.contains(v), ErrorCode::bad_input, "a voxel outside the grid has no state to set");
  const std::size_t w = word(v);
  const std::uint64_t b = bit(v);
  const auto put = [b](std::uint64_t& word_bits, bool on) { word_bits = on ? word_bits | b : word_bits & ~b; };
  put(occupied_[w], s != VoxelState::empty);
  put(known_[w], s == VoxelState::known);
  put(environment_[w], s == VoxelState::environment);
}

Counts OccupancyGrid::counts() const {
  Counts c;
  std::uint64_t occupied = 0;
  for (std::size_t w = 0; w < occupied_.size(); ++w) {
    occupied += static_cast<std::uint64_t>(std::popcount(occupied_[w]));
    c.environment += static_cast<std::uint64_t>(std::popcount(occupied_[w] & environment_[w]));
    c.known += static_cast<std::uint64_t>(std::popcount(occupied_[w] & known_[w] & ~environment_[w]));
  }
  c.unknown = occupied - c.known - c.environment;
  const std::uint64_t all = static_cast<std::uint64_t>(geometry_.size.x()) * static_cast<std::uint64_t>(geometry_.size.y()) *
                            static_cast<std::uint64_t>(geometry_.size.z());
  c.empty = all - occupied;
  return c;
}

void OccupancyGrid::adopt(std::vector<std::uint64_t> occupied, std::vector<std::uint64_t> known,
                          std::vector<std::uint64_t> environment) {
  const std::size_t words = word_count(geometry_);
  require(occupied.size() == words && known.size() == words && environment.size() == words, ErrorCode::bad_size,
          "each plane of the grid needs " + std::to_string(words) + " words of 64 bits");
  for_each_word(geometry_, [&](std::size_t w, std::uint64_t mask) {
    occupied[w] &= mask;
    environment[w] &= occupied[w];
    known[w] &= occupied[w] & ~environment[w];
  });
  occupied_ = std::move(occupied);
  known_ = std::move(known);
  environment_ = std::move(environment);
}

}  // namespace periplus::voxel
