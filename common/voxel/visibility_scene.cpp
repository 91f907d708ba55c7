// What a VisibilityScene is built of, once for a revision of the grid.
#include <algorithm>
#include <bit>
#include <utility>

#include "common/core/error.h"
#include "common/voxel/brick_field.h"
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

// A byte for each of eight bits: 1 or 0.
std::uint64_t bytes_of(std::uint64_t bits) {
  return (((bits & 0xff) * kZLow & 0x8040201008040201ull) + 0x7f7f7f7f7f7f7f7full) >> 7 & kZLow;
}

// The codes of a word's 64 voxels, eight at a time.
void put_codes(std::uint32_t x, std::uint64_t unknown, std::uint64_t environment, std::uint64_t watched, std::uint32_t* codes) {
  static_assert(kVoxelUnknown < 256 && kVoxelEnvironment < 256 && kVoxelWatched < 256);
  for (std::uint32_t y = 0; y < 8; ++y) {
    const std::uint64_t is = bytes_of(unknown >> 8 * y) * kVoxelUnknown | bytes_of(environment >> 8 * y) * kVoxelEnvironment |
                             bytes_of(watched >> 8 * y) * kVoxelWatched;
    const std::uint32_t line = x | y << kVoxelY;
    for (std::uint32_t z = 0; z < 8; ++z) codes[8 * y + z] = line | z << kVoxelZ | static_cast<std::uint32_t>(is >> 8 * z & 0xff);
  }
}

}  // namespace

VisibilityScene::VisibilityScene(const OccupancyGrid& grid, const std::vector<Occluder>& occluders, const std::vector<Eigen::Vector3i>& watched)
    : VisibilityScene(std::make_shared<const ExposedFaces>(grid), occluders, watched) {}

VisibilityScene::VisibilityScene(std::shared_ptr<const ExposedFaces> faces, const std::vector<Occluder>& occluders,
                                 const std::vector<Eigen::Vector3i>& watched, const VisibilityScene* before)
    : geometry_(faces->geometry()), bricks_(geometry_.bricks()), faces_(std::move(faces)) {
  require((geometry_.size.array() <= Eigen::Array3i(1024, 1024, 512)).all(), ErrorCode::bad_input,
          "visibility takes grids of at most 1024 x 1024 x 512 voxels; choose larger voxels or a smaller box");
  require(!before || before->geometry_.size == geometry_.size, ErrorCode::bad_size, "a scene takes over from one of the same grid");
  watched_ = watched.size();
  lists_ = list_voxels(watched, before);
  put_occluders(occluders);
}

void VisibilityScene::put_occluders(const std::vector<Occluder>& occluders) {
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

// Appends a brick of voxels with a free face; `watch`: those that are watched, if there are any.
void VisibilityScene::list_brick(const ExposedBrick& p, const Eigen::Vector3i& at, const std::array<std::uint64_t, 8>* watch, Lists& lists) {
  VisibilityBrick brick{};
  for (int a = 0; a < 3; ++a) brick.at[a] = at[a];
  std::uint64_t any[8], counts[8];  // voxels with a free face; unknown or watched
  for (std::size_t x = 0; x < 8; ++x) {
    any[x] = p.exposed(x);
    counts[x] = p.unknown[x];
  }
  for (std::size_t x = 0; watch && x < 8; ++x) counts[x] |= (*watch)[x];
  box_of(any, at, brick.middle, brick.extent);
  std::uint32_t codes[512];
  for (std::size_t x = 0; x < 8; ++x)
    if (any[x] != 0) put_codes(static_cast<std::uint32_t>(x) << kVoxelX, p.unknown[x], p.environment[x], watch ? (*watch)[x] : 0, codes + 64 * x);
  Counted counted{static_cast<std::int32_t>(lists.bricks.size()), 0, {}, {}};
  for (int octant = 0; octant < 8; ++octant) {
    brick.first[octant] = static_cast<std::uint32_t>(lists.codes.size());
    const int up[3] = {octant & 1, octant >> 1 & 1, octant >> 2 & 1};
    std::uint32_t outward[512];
    std::uint32_t* end = outward;
    std::uint64_t of_interest = 0;
    const int turned = (up[1] != 0 ? 56 : 0) | (up[2] != 0 ? 7 : 0);
    for (int i = 0; i < 8; ++i) {
      const int x = up[0] != 0 ? 7 - i : i;
      std::uint64_t seen = p.free_face[up[0]][x] | p.free_face[2 + up[1]][x] | p.free_face[4 + up[2]][x];
      of_interest |= seen & counts[x];
      if (up[1] != 0) seen = __builtin_bswap64(seen);
      if (up[2] != 0) seen = with_lines_turned(seen);
      for (const std::uint32_t* const plane = &codes[64 * x]; seen != 0; seen &= seen - 1) *end++ = plane[std::countr_zero(seen) ^ turned];
    }
    lists.codes.insert(lists.codes.end(), outward, end);
    brick.count[octant] = static_cast<std::uint16_t>(end - outward);
    if (of_interest != 0) counted.octants |= static_cast<std::uint8_t>(1 << octant);
  }
  if (counted.octants != 0) {
    for (int x = 0; x < 8; ++x) any[x] &= counts[x];
    box_of(any, at, counted.middle, counted.extent);
    lists.counted.push_back(counted);
  }
  lists.bricks.push_back(brick);
}

// Appends brick `from` of `before`.
void VisibilityScene::take_over(const Lists& before, std::size_t from, const Counted* counted, Lists& lists) {
  VisibilityBrick brick = before.bricks[from];
  const std::uint32_t begin = brick.first[0], end = brick.first[7] + brick.count[7], at = static_cast<std::uint32_t>(lists.codes.size());
  lists.codes.insert(lists.codes.end(), before.codes.begin() + begin, before.codes.begin() + end);
  for (std::uint32_t& first : brick.first) first = first - begin + at;
  if (counted) {
    lists.counted.push_back(*counted);
    lists.counted.back().brick = static_cast<std::int32_t>(lists.bricks.size());
  }
  lists.bricks.push_back(brick);
}

std::shared_ptr<const VisibilityScene::Lists> VisibilityScene::list_voxels(const std::vector<Eigen::Vector3i>& watched, const VisibilityScene* before) const {
  if (before && before->watched_ != 0) before = nullptr;  // its codes say so
  if (before && before->faces_ == faces_ && watched.empty()) return before->lists_;
  BrickField<std::array<std::uint64_t, 8>> marked;
  if (!watched.empty()) marked = BrickField<std::array<std::uint64_t, 8>>(geometry_);
  for (const Eigen::Vector3i& v : watched)
    if (geometry_.contains(v)) marked.hold(brick_of(geometry_, v))[v.x() & 7] |= OccupancyGrid::bit(v);
  auto lists = std::make_shared<Lists>();
  faces_->for_each([&](const ExposedBrick& p) {
    for (std::size_t x = 0; x < 8; ++x) lists->surface += static_cast<std::size_t>(std::popcount(p.exposed(x)));
  });
  lists->bricks.reserve(faces_->held());
  lists->codes.reserve(8 * lists->surface + 16);  // at most
  std::size_t old = 0, old_counted = 0;  // the next of `before`: both are in the order of the bricks
  const auto index_of = [&](const VisibilityBrick& b) { return static_cast<std::uint32_t>((b.at[0] * bricks_.y() + b.at[1]) * bricks_.z() + b.at[2]); };
  faces_->for_each([&](const ExposedBrick& p) {
    const std::array<std::uint64_t, 8>* watch = watched.empty() ? nullptr : marked.find(p.brick);
    const ExposedBrick* same = before && !watch ? before->faces_->find(p.brick) : nullptr;
    if (!same || !(*same == p)) return list_brick(p, geometry_.brick_position(p.brick), watch, *lists);
    const Lists& from = *before->lists_;
    while (index_of(from.bricks[old]) < p.brick) ++old;
    while (old_counted < from.counted.size() && static_cast<std::size_t>(from.counted[old_counted].brick) < old) ++old_counted;
    const bool counts = old_counted < from.counted.size() && static_cast<std::size_t>(from.counted[old_counted].brick) == old;
    take_over(from, old, counts ? &from.counted[old_counted] : nullptr, *lists);
  });
  lists->codes.resize(lists->codes.size() + 16);
  return lists;
}

std::size_t VisibilityScene::unknown_face_count() const {
  std::size_t count = 0;
  faces_->for_each([&](const ExposedBrick& b) {
    for (int d = 0; d < 6; ++d) {
      for (int x = 0; x < 8; ++x) count += static_cast<std::size_t>(std::popcount(b.free_face[d][x] & b.unknown[x]));
    }
  });
  return count;
}

std::vector<VisibilityScene::Face> VisibilityScene::unknown_faces(std::size_t stride) const {
  std::vector<Face> faces;
  std::size_t seen = 0;
  faces_->for_each([&](const ExposedBrick& b) {
    const Eigen::Vector3i first = 8 * geometry_.brick_position(b.brick);
    for (int d = 0; d < 6; ++d) {
      for (int x = 0; x < 8; ++x) {
        for (std::uint64_t word = b.free_face[d][x] & b.unknown[x]; word != 0; word &= word - 1) {
          if (seen++ % std::max<std::size_t>(stride, 1) != 0) continue;
          const int bit = std::countr_zero(word);
          faces.push_back({index(first + Eigen::Vector3i(x, bit >> 3, bit & 7)), d});
        }
      }
    }
  });
  return faces;
}

std::vector<std::uint32_t> VisibilityScene::surface() const {
  std::vector<std::uint32_t> voxels;
  faces_->for_each([&](const ExposedBrick& b) {
    const Eigen::Vector3i first = 8 * geometry_.brick_position(b.brick);
    for (int x = 0; x < 8; ++x) {
      for (std::uint64_t word = b.exposed(static_cast<std::size_t>(x)); word != 0; word &= word - 1) {
        const int bit = std::countr_zero(word);
        voxels.push_back(index(first + Eigen::Vector3i(x, bit >> 3, bit & 7)));
      }
    }
  });
  return voxels;
}

}  // namespace periplus::voxel
