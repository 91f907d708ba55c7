// What a VisibilityScene is built of, once for a revision of the grid.
#include <algorithm>
#include <bit>
#include <utility>

#include "common/core/error.h"
#include "common/voxel/convex.h"
#include "common/voxel/visibility.h"

namespace periplus::voxel {
namespace {

constexpr std::uint64_t kZLow = 0x0101010101010101ull;  // z = 0 of each y

// The box around those voxels of a brick that are set (some are): its middle and side lengths.
void box_of(const std::uint64_t (&set)[8], const Eigen::Vector3i& at, float (&middle)[3], float (&extent)[3]) {
  std::uint64_t all = 0;
  for (std::uint64_t word : set) all |= word;
  for (int a = 0; a < 3; ++a) {
    int low = 7, high = 0;
    for (int t = 0; t < 8; ++t) {
      if ((a == 0 ? set[t] : all & (a == 1 ? 0xffull << (8 * t) : kZLow << t)) == 0) continue;
      low = std::min(low, t);
      high = std::max(high, t + 1);
    }
    middle[a] = static_cast<float>(8 * at[a]) + 0.5f * static_cast<float>(low + high);
    extent[a] = static_cast<float>(high - low);
  }
}

// Each line along z the other way round.
std::uint64_t with_lines_turned(std::uint64_t word) {
  word = (word >> 1 & 0x5555555555555555ull) | (word & 0x5555555555555555ull) << 1;
  word = (word >> 2 & 0x3333333333333333ull) | (word & 0x3333333333333333ull) << 2;
  return (word >> 4 & 0x0f0f0f0f0f0f0f0full) | (word & 0x0f0f0f0f0f0f0f0full) << 4;
}

}  // namespace

VisibilityScene::VisibilityScene(const OccupancyGrid& grid, const std::vector<Occluder>& occluders,
                                 const std::vector<Eigen::Vector3i>& watched)
    : geometry_(grid.geometry()), bricks_(geometry_.bricks()) {
  geometry_.check();
  require((geometry_.size.array() <= Eigen::Array3i(1024, 1024, 512)).all(), ErrorCode::bad_input,
          "visibility takes grids of at most 1024 x 1024 x 512 voxels; choose larger voxels or a smaller box");
  const Eigen::Vector3i n = bricks_;
  const auto brick_at = [&](const Eigen::Vector3i& b) -> std::ptrdiff_t {
    if ((b.array() < 0).any() || (b.array() >= n.array()).any()) return -1;
    return (static_cast<std::ptrdiff_t>(b.x()) * n.y() + b.y()) * n.z() + b.z();
  };
  const auto word_at = [&](const Eigen::Vector3i& b, int x) -> std::uint64_t {
    const std::ptrdiff_t at = brick_at(b);
    return at < 0 ? 0 : grid.occupied()[at * 8 + x];
  };
  std::vector<std::int32_t> index(static_cast<std::size_t>(n.x()) * n.y() * n.z(), -1);  // brick -> planes_
  for (int bx = 0; bx < n.x(); ++bx) {
    for (int by = 0; by < n.y(); ++by) {
      for (int bz = 0; bz < n.z(); ++bz) {
        const Eigen::Vector3i at(bx, by, bz);
        const std::size_t base = static_cast<std::size_t>(brick_at(at)) * 8;
        Planes brick{};
        brick.at = at;
        std::uint64_t any = 0;
        for (int x = 0; x < 8; ++x) {
          const std::uint64_t w = grid.occupied()[base + x];
          if (w == 0) continue;
          // Occupancy of each voxel's neighbour in the six directions.
          const std::uint64_t neighbours[6] = {
              x > 0 ? grid.occupied()[base + x - 1] : word_at(at - Eigen::Vector3i::UnitX(), 7),
              x < 7 ? grid.occupied()[base + x + 1] : word_at(at + Eigen::Vector3i::UnitX(), 0),
              w << 8 | word_at(at - Eigen::Vector3i::UnitY(), x) >> 56,
              w >> 8 | word_at(at + Eigen::Vector3i::UnitY(), x) << 56,
              (w & ~(kZLow << 7)) << 1 | (word_at(at - Eigen::Vector3i::UnitZ(), x) >> 7 & kZLow),
              (w & ~kZLow) >> 1 | (word_at(at + Eigen::Vector3i::UnitZ(), x) & kZLow) << 7};
          std::uint64_t free = 0;
          for (int d = 0; d < 6; ++d) {
            brick.free_face[d][x] = w & ~neighbours[d];
            free |= brick.free_face[d][x];
          }
          any |= free;
          surface_ += static_cast<std::size_t>(std::popcount(free));
          brick.environment[x] = w & grid.environment()[base + x];
          brick.unknown[x] = w & ~grid.known()[base + x] & ~grid.environment()[base + x];
        }
        if (any == 0) continue;
        index[base / 8] = static_cast<std::int32_t>(planes_.size());
        planes_.push_back(brick);
      }
    }
  }
  for (const Eigen::Vector3i& v : watched) {
    if (!geometry_.contains(v)) continue;
    const std::int32_t at = index[brick_at(Eigen::Vector3i(v.x() / 8, v.y() / 8, v.z() / 8))];
    if (at >= 0) planes_[at].watched[v.x() & 7] |= OccupancyGrid::bit(v);
  }
  watched_ = watched.size();
  list_voxels();
  const Pose X_GW = geometry_.X_WG.inverse();
  for (const Occluder& occluder : occluders) {
    Points points;
    for (const auto& p : occluder.points_W) points.push_back(X_GW * p / geometry_.voxel_size);
    for (int d = 0; d < 6; ++d) {
      const int axis = d / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
      const double side = d % 2 == 0 ? 0.0 : geometry_.size[axis];
      const auto value = [&](const Eigen::Vector3d& p) { return d % 2 == 0 ? -p[axis] : p[axis] - side; };
      Points part;
      std::vector<Eigen::Vector2d> section;  // of many crossing points only the outline matters
      for (const auto& p : clip(points, value)) {
        if (value(p) > 1e-9) {
          part.push_back(p);
        } else {
          section.emplace_back(p[a], p[b]);
        }
      }
      if (part.empty()) continue;  // the solid only touches this side
      for (const auto& q : convex_hull(std::move(section))) {
        Eigen::Vector3d p;
        p[axis] = side;
        p[a] = q.x();
        p[b] = q.y();
        part.push_back(p);
      }
      beyond_[d].push_back(std::move(part));
    }
  }
}

void VisibilityScene::list_voxels() {
  list_.reserve(planes_.size());
  codes_.reserve(8 * surface_ + 16);  // at most
  for (const Planes& p : planes_) {
    VisibilityBrick brick{};
    for (int a = 0; a < 3; ++a) brick.at[a] = p.at[a];
    std::uint64_t any[8] = {};  // voxels with a free face
    for (int x = 0; x < 8; ++x) {
      for (int d = 0; d < 6; ++d) any[x] |= p.free_face[d][x];
    }
    box_of(any, p.at, brick.middle, brick.extent);
    std::uint32_t codes[512];
    const auto is = [](std::uint64_t word, std::uint32_t bit) { return static_cast<std::uint32_t>(word >> bit & 1); };
    for (std::uint32_t x = 0; x < 8; ++x) {
      if (any[x] == 0) continue;
      for (std::uint32_t bit = 0; bit < 64; ++bit)
        codes[64 * x + bit] = x << kVoxelX | (bit >> 3) << kVoxelY | (bit & 7) << kVoxelZ | is(p.unknown[x], bit) * kVoxelUnknown |
                              is(p.environment[x], bit) * kVoxelEnvironment | is(p.watched[x], bit) * kVoxelWatched;
    }
    Counted counted{static_cast<std::int32_t>(list_.size()), 0, {}, {}};
    for (int octant = 0; octant < 8; ++octant) {
      brick.first[octant] = static_cast<std::uint32_t>(codes_.size());
      const int up[3] = {octant & 1, octant >> 1 & 1, octant >> 2 & 1};
      std::uint32_t outward[512];
      std::uint32_t* end = outward;
      std::uint64_t of_interest = 0;
      const int turned = (up[1] != 0 ? 56 : 0) | (up[2] != 0 ? 7 : 0);
      for (int i = 0; i < 8; ++i) {
        const int x = up[0] != 0 ? 7 - i : i;
        std::uint64_t seen = p.free_face[up[0]][x] | p.free_face[2 + up[1]][x] | p.free_face[4 + up[2]][x];
        of_interest |= seen & (p.unknown[x] | p.watched[x]);
        if (up[1] != 0) seen = __builtin_bswap64(seen);
        if (up[2] != 0) seen = with_lines_turned(seen);
        for (const std::uint32_t* const plane = &codes[64 * x]; seen != 0; seen &= seen - 1) *end++ = plane[std::countr_zero(seen) ^ turned];
      }
      codes_.insert(codes_.end(), outward, end);
      brick.count[octant] = static_cast<std::uint16_t>(end - outward);
      if (of_interest != 0) counted.octants |= static_cast<std::uint8_t>(1 << octant);
    }
    if (counted.octants != 0) {
      for (int x = 0; x < 8; ++x) any[x] &= p.unknown[x] | p.watched[x];
      box_of(any, p.at, counted.middle, counted.extent);
      counted_.push_back(counted);
    }
    list_.push_back(brick);
  }
  codes_.resize(codes_.size() + 16);
}

std::size_t VisibilityScene::unknown_face_count() const {
  std::size_t count = 0;
  for (const Planes& b : planes_) {
    for (int d = 0; d < 6; ++d) {
      for (int x = 0; x < 8; ++x) count += std::popcount(b.free_face[d][x] & b.unknown[x]);
    }
  }
  return count;
}

std::vector<VisibilityScene::Face> VisibilityScene::unknown_faces(std::size_t stride) const {
  std::vector<Face> faces;
  std::size_t seen = 0;
  for (const Planes& b : planes_) {
    for (int d = 0; d < 6; ++d) {
      for (int x = 0; x < 8; ++x) {
        for (std::uint64_t word = b.free_face[d][x] & b.unknown[x]; word != 0; word &= word - 1) {
          if (seen++ % std::max<std::size_t>(stride, 1) != 0) continue;
          const int bit = std::countr_zero(word);
          faces.push_back({index(Eigen::Vector3i(b.at[0] * 8 + x, b.at[1] * 8 + (bit >> 3), b.at[2] * 8 + (bit & 7))), d});
        }
      }
    }
  }
  return faces;
}

std::vector<std::uint32_t> VisibilityScene::surface() const {
  std::vector<std::uint32_t> voxels;
  for (const Planes& b : planes_) {
    for (int x = 0; x < 8; ++x) {
      std::uint64_t word = 0;
      for (int d = 0; d < 6; ++d) word |= b.free_face[d][x];
      for (; word != 0; word &= word - 1) {
        const int bit = std::countr_zero(word);
        voxels.push_back(index(Eigen::Vector3i(b.at[0] * 8 + x, b.at[1] * 8 + (bit >> 3), b.at[2] * 8 + (bit & 7))));
      }
    }
  }
  return voxels;
}

}  // namespace periplus::voxel
