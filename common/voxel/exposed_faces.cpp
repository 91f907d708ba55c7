#include "common/voxel/exposed_faces.h"

#include <algorithm>

#include "common/core/error.h"

namespace periplus::voxel {
namespace {

constexpr std::uint64_t kLineStarts = 0x0101010101010101ull;  // z = 0 of each y
constexpr std::uint64_t kNothing[8] = {};                     // beyond the grid

bool same(const GridGeometry& a, const GridGeometry& b) {
  return a.size == b.size && a.voxel_size == b.voxel_size && a.X_WG.matrix() == b.X_WG.matrix();
}

bool is_empty(const OccupancyGrid& grid, std::size_t brick) {
  std::uint64_t any = 0;
  for (std::size_t x = 0; x < 8; ++x) any |= grid.occupied()[8 * brick + x];
  return any == 0;
}

// The words of the brick at `at` [bricks]; false, and nothing is said, if it has no free face.
bool find_faces(const OccupancyGrid& grid, std::size_t brick, const Eigen::Vector3i& at, ExposedBrick& out) {
  const std::uint64_t* const own = &grid.occupied()[8 * brick];
  const Eigen::Vector3i n = grid.geometry().bricks();
  const std::ptrdiff_t step[3] = {8 * static_cast<std::ptrdiff_t>(n.y()) * n.z(), 8 * static_cast<std::ptrdiff_t>(n.z()), 8};
  const std::uint64_t* beside[6];  // the six neighbours' words
  for (int a = 0; a < 3; ++a) {
    beside[2 * a] = at[a] > 0 ? own - step[a] : kNothing;
    beside[2 * a + 1] = at[a] + 1 < n[a] ? own + step[a] : kNothing;
  }
  std::uint64_t any = 0;
  for (int x = 0; x < 8; ++x) {
    const std::uint64_t w = own[x];
    // Occupancy of each voxel's neighbour in the six directions.
    const std::uint64_t covered[6] = {
        x > 0 ? own[x - 1] : beside[0][7],
        x < 7 ? own[x + 1] : beside[1][0],
        w << 8 | beside[2][x] >> 56,
        w >> 8 | beside[3][x] << 56,
        (w & ~(kLineStarts << 7)) << 1 | (beside[4][x] >> 7 & kLineStarts),
        (w & ~kLineStarts) >> 1 | (beside[5][x] & kLineStarts) << 7};
    for (int d = 0; d < 6; ++d) any |= out.free_face[d][x] = w & ~covered[d];
  }
  if (any == 0) return false;
  out.brick = static_cast<std::uint32_t>(brick);
  for (std::size_t x = 0; x < 8; ++x) {
    const std::size_t word = 8 * brick + x;
    out.environment[x] = own[x] & grid.environment()[word];
    out.unknown[x] = own[x] & ~grid.known()[word] & ~grid.environment()[word];
  }
  return true;
}

}  // namespace

ExposedFaces::ExposedFaces(const OccupancyGrid& grid) : geometry_(grid.geometry()) {
  geometry_.check();
  slots_.assign(voxel::brick_count(geometry_), kNone);
  const Eigen::Vector3i n = geometry_.bricks();
  std::size_t brick = 0;
  for (int x = 0; x < n.x(); ++x)
    for (int y = 0; y < n.y(); ++y)
      for (int z = 0; z < n.z(); ++z) look_at(grid, brick++, {x, y, z});
}

void ExposedFaces::update(const OccupancyGrid& grid, const BrickMarks& changed) {
  require(same(grid.geometry(), geometry_), ErrorCode::bad_size, "the exposed faces are those of a grid of another geometry; make them anew");
  require(changed.size() == slots_.size(), ErrorCode::bad_size, "exposed faces are brought up to date by one mark for each brick of the grid");
  const Eigen::Vector3i n = geometry_.bricks();
  const std::size_t step[3] = {static_cast<std::size_t>(n.y()) * n.z(), static_cast<std::size_t>(n.z()), 1};
  BrickMarks stale = changed;
  for (std::size_t b = 0; b < changed.size(); ++b) {
    if (changed[b] == 0) continue;
    const Eigen::Vector3i at = geometry_.brick_position(b);
    for (int a = 0; a < 3; ++a) {
      if (at[a] > 0) stale[b - step[a]] = 1;
      if (at[a] + 1 < n[a]) stale[b + step[a]] = 1;
    }
  }
  for (std::size_t b = 0; b < stale.size(); ++b)
    if (stale[b] != 0) look_at(grid, b, geometry_.brick_position(b));
}

void ExposedFaces::look_at(const OccupancyGrid& grid, std::size_t brick, const Eigen::Vector3i& at) {
  std::uint32_t& slot = slots_[brick];
  const bool empty = is_empty(grid, brick);
  if (empty && slot == kNone) return;
  ExposedBrick found;
  if (!empty && find_faces(grid, brick, at, found)) {
    if (slot == kNone) {
      slot = static_cast<std::uint32_t>(bricks_.size());
      bricks_.push_back(found);
    } else {
      bricks_[slot] = found;
    }
  } else if (slot != kNone) {  // the last one takes its place
    slots_[bricks_.back().brick] = slot;
    bricks_[slot] = bricks_.back();
    bricks_.pop_back();
    slot = kNone;
  }
}

bool ExposedFaces::operator==(const ExposedFaces& other) const {
  if (!same(geometry_, other.geometry_) || held() != other.held()) return false;
  return std::all_of(bricks_.begin(), bricks_.end(), [&](const ExposedBrick& mine) {
    const ExposedBrick* theirs = other.find(mine.brick);
    return theirs && *theirs == mine;
  });
}

}  // namespace periplus::voxel
