#include "services/nbv_planner/likely_surface.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace periplus::nbv {
namespace {

// Bits along z, row by row: 64 of them a word.
class Rows {
 public:
  explicit Rows(const Eigen::Vector3i& size)
      : size_(size), words_((size.z() + 63) / 64), bits_(static_cast<std::size_t>(size.x()) * size.y() * words_, 0) {}

  std::uint64_t* row(int x, int y) { return bits_.data() + (static_cast<std::size_t>(x) * size_.y() + y) * words_; }
  // Eight voxels from z = 8 k on.
  std::uint64_t eight(int x, int y, int k) { return row(x, y)[k >> 3] >> (k & 7) * 8 & 0xff; }

  // Across faces, or across faces, edges and corners. `spare` is scratch of the same size.
  void grow(bool corners, Rows& spare) {
    along_z(corners ? *this : spare);
    if (corners) {
      across(*this, spare, 1);
      across(spare, *this, 0);
      return;
    }
    // spare has the rows grown along z; those beside come ungrown.
    for (int x = 0; x < size_.x(); ++x) {
      for (int y = 0; y < size_.y(); ++y) {
        for (const auto& [i, j] : {std::pair(x - 1, y), std::pair(x + 1, y), std::pair(x, y - 1), std::pair(x, y + 1)}) {
          if (i < 0 || j < 0 || i >= size_.x() || j >= size_.y()) continue;
          add(row(i, j), spare.row(x, y));
        }
      }
    }
    bits_.swap(spare.bits_);
  }

 private:
  void add(const std::uint64_t* from, std::uint64_t* to) const {
    for (int w = 0; w < words_; ++w) to[w] |= from[w];
  }
  void along_z(Rows& out) {
    for (std::size_t at = 0; at < bits_.size(); at += words_) {
      std::uint64_t before = 0;
      for (int w = 0; w < words_; ++w) {
        const std::uint64_t here = bits_[at + w], after = w + 1 < words_ ? bits_[at + w + 1] : 0;
        out.bits_[at + w] = here | here << 1 | here >> 1 | before >> 63 | after << 63;
        before = here;
      }
    }
  }
  // Each row with its neighbours along x (axis 0) or y (axis 1).
  static void across(Rows& in, Rows& out, int axis) {
    out.bits_ = in.bits_;
    for (int x = 0; x < in.size_.x(); ++x) {
      for (int y = 0; y < in.size_.y(); ++y) {
        if (axis == 0) {
          if (x > 0) in.add(in.row(x - 1, y), out.row(x, y));
          if (x + 1 < in.size_.x()) in.add(in.row(x + 1, y), out.row(x, y));
        } else {
          if (y > 0) in.add(in.row(x, y - 1), out.row(x, y));
          if (y + 1 < in.size_.y()) in.add(in.row(x, y + 1), out.row(x, y));
        }
      }
    }
  }

  Eigen::Vector3i size_;
  int words_;
  std::vector<std::uint64_t> bits_;
};

}  // namespace

voxel::OccupancyGrid likely_surface(const voxel::OccupancyGrid& grid, int within) {
  const auto& known = grid.known();
  if (within <= 0 || std::all_of(known.begin(), known.end(), [](std::uint64_t w) { return w == 0; })) return grid;

  const Eigen::Vector3i n = grid.geometry().size, bricks = grid.geometry().bricks();
  Rows near(n), spare(n);
  std::size_t word = 0;
  for (int bx = 0; bx < bricks.x(); ++bx) {
    for (int by = 0; by < bricks.y(); ++by) {
      for (int bz = 0; bz < bricks.z(); ++bz) {
        for (int x = 0; x < 8; ++x, ++word) {
          for (int y = 0; known[word] != 0 && y < 8; ++y) {
            const std::uint64_t eight = known[word] >> (8 * y) & 0xff;
            if (eight != 0) near.row(bx * 8 + x, by * 8 + y)[bz >> 3] |= eight << (bz & 7) * 8;
          }
        }
      }
    }
  }
  for (int i = 0; i < within; ++i) near.grow(i % 2 == 1, spare);

  voxel::OccupancyGrid likely = grid;
  word = 0;
  for (int bx = 0; bx < bricks.x(); ++bx) {
    for (int by = 0; by < bricks.y(); ++by) {
      for (int bz = 0; bz < bricks.z(); ++bz) {
        for (int x = 0; x < 8; ++x, ++word) {
          const std::uint64_t unknown = likely.occupied()[word] & ~known[word] & ~grid.environment()[word];
          if (unknown == 0) continue;
          for (int y = 0; y < 8; ++y) {
            const std::uint64_t eight = unknown >> (8 * y) & 0xff;
            if (eight != 0) likely.occupied()[word] &= ~((eight & ~near.eight(bx * 8 + x, by * 8 + y, bz)) << (8 * y));
          }
        }
      }
    }
  }
  return likely;
}

}  // namespace periplus::nbv
