#include "common/object_model/evidence.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <future>
#include <limits>

#include "common/core/error.h"
#include "common/object_model/evidence_kernel.h"

namespace periplus::object_model {

namespace {

template <class T>
void count(T& counter, int n) {
  counter = static_cast<T>(std::min<int>(counter + n, std::numeric_limits<T>::max()));
}

// Adds the codes of one step; neighbours in the image mostly fall into the same voxel and are added at once. Which codes are a voxel's and where their
// run ends comes as bits, for no processor foresees such branches.
template <class Counters>
void add_codes(const std::int32_t* codes, const RunBits& bits, voxel::BrickField<EvidenceBrick>& bricks, Counters&& counters) {
  for (std::uint64_t voxels = bits.voxels; voxels != 0; voxels &= voxels - 1) {
    const int begin = std::countr_zero(voxels);
    const std::uint64_t later = bits.changes & (~1ull << begin);
    const int end = std::countr_zero(later);  // kRun where there is none
    const std::int32_t code = codes[begin];
    EvidenceBrick& brick = bricks.hold(static_cast<std::size_t>(code >> 10));
    count(counters(brick, code & 1)[static_cast<std::size_t>(code >> 1 & (voxel::kBrickVoxels - 1))], end - begin);
  }
}

GridRays grid_rays(const DepthMap& map, const voxel::GridGeometry& g, double margin_voxels) {
  const double h = g.voxel_size;
  const Pose X_GC = g.X_WG.inverse() * map.X_WC;
  const Eigen::Vector3d origin = X_GC.translation() / h, du = X_GC.linear().col(0) / (map.camera.fx * h), dv = X_GC.linear().col(1) / (map.camera.fy * h);
  const Eigen::Vector3d d1 = X_GC.linear() * map.camera.back_project(0, 0, 1) / h;
  GridRays r;
  for (int n = 0; n < 3; ++n) {
    r.origin[n] = static_cast<float>(origin[n]);
    r.du[n] = static_cast<float>(du[n]);
    r.dv[n] = static_cast<float>(dv[n]);
    r.d1[n] = static_cast<float>(d1[n]);
    r.size[n] = g.size[n];
    r.bricks[n] = g.bricks()[n];
  }
  r.voxel_m = static_cast<float>(h);
  r.focal_px = static_cast<float>(std::min(map.camera.fx, 1e6));  // a voxel is wider than any image then
  r.margin_m = static_cast<float>(margin_voxels * h);
  r.minimum = map.depth_minimum.data.data();
  r.width = map.depth.width;
  r.height = map.depth.height;
  return r;
}

}  // namespace

VoxelEvidence Evidence::at(const Eigen::Vector3i& v) const {
  const EvidenceBrick* brick = bricks_.find(voxel::brick_of(geometry_, v));
  if (!brick) return {};
  const auto i = static_cast<std::size_t>(voxel::within_brick(v));
  return {brick->points[i], brick->seen[i], brick->solid[i], brick->votes[i]};
}

void Evidence::set(const Eigen::Vector3i& v, const VoxelEvidence& e) {
  EvidenceBrick& brick = bricks_.hold(voxel::brick_of(geometry_, v));
  const auto i = static_cast<std::size_t>(voxel::within_brick(v));
  brick.points[i] = e.points;
  brick.seen[i] = e.seen;
  brick.solid[i] = e.solid;
  brick.votes[i] = e.votes;
}

void add_points(const DepthMap& map, const PixelLimits& limits, const voxel::GridGeometry& geometry, double margin_voxels, Evidence& evidence,
                voxel::Simd simd) {
  require(map.depth.width == map.depth_minimum.width && map.depth.height == map.depth_minimum.height && limits.kind.width == map.depth.width &&
              limits.kind.height == map.depth.height,
          ErrorCode::bad_size, "depth, least depth and limits must have one size");
  const GridRays rays = grid_rays(map, geometry, margin_voxels);
  simd = voxel::resolve(simd);
  RunVoxels voxels;
  // The last pixels of a row, filled up.
  float last_depth[kRun] = {}, last_sigma[kRun] = {};
  std::uint8_t last_kind[kRun] = {};
  const bool has_sigma = map.depth_sigma.data.size() == map.depth.data.size();
  static_assert(sizeof(PixelKind) == 1);
  for (int y = 0; y < rays.height; ++y) {
    for (int x0 = 0; x0 < rays.width; x0 += kRun) {
      const int n = std::min(kRun, rays.width - x0);
      const std::size_t at = static_cast<std::size_t>(y) * rays.width + x0;
      const float *depth = &map.depth.data[at], *sigma = has_sigma ? &map.depth_sigma.data[at] : last_sigma;
      const auto* kind = reinterpret_cast<const std::uint8_t*>(&limits.kind.data[at]);
      if (n < kRun) {
        depth = std::copy_n(depth, n, last_depth) - n;
        if (has_sigma) sigma = std::copy_n(sigma, n, last_sigma) - n;
        kind = std::copy_n(kind, n, last_kind) - n;
      }
      std::uint64_t kinds[kRun / 8], any = 0;
      std::memcpy(kinds, kind, kRun);
      for (const std::uint64_t eight : kinds) any |= eight;
      if (any == 0) continue;
      run_voxels(rays, x0, y, depth, sigma, kind, voxels, simd);
      if (voxels.steps == 0) continue;
      add_codes(voxels.point, voxels.point_bits, evidence.bricks(), [](EvidenceBrick& b, int) { return b.points.data(); });
      for (int k = 0; k < voxels.steps; ++k)
        add_codes(voxels.step[k], voxels.step_bits[k], evidence.bricks(), [](EvidenceBrick& b, int solid) { return solid != 0 ? b.solid.data() : b.seen.data(); });
    }
  }
}

void empty_voxels(const std::vector<std::uint64_t>& plane, int votes, voxel::OccupancyGrid& grid, Evidence& evidence, voxel::BrickMarks* changed) {
  for (std::size_t word = 0; word < plane.size(); ++word) {
    std::uint64_t empty = plane[word];
    if (empty == 0) continue;
    if (votes > 1) {
      EvidenceBrick& brick = evidence.bricks().hold(word / 8);
      for (std::uint64_t bits = empty; bits; bits &= bits - 1) {
        const int b = std::countr_zero(bits);
        std::uint8_t& counter = brick.votes[word % 8 * 64 + static_cast<std::size_t>(b)];
        count(counter, 1);
        if (counter < votes) empty &= ~(1ull << b);
      }
    }
    if (changed && ((grid.occupied()[word] | grid.known()[word] | grid.environment()[word]) & empty) != 0) (*changed)[word / 8] = 1;
    grid.occupied()[word] &= ~empty;
    grid.known()[word] &= ~empty;
    grid.environment()[word] &= ~empty;
  }
}

void carve_and_count(const DepthMap& map, const PixelLimits& limits, double margin_voxels, int votes, voxel::OccupancyGrid& grid, Evidence& evidence,
                     voxel::BrickMarks* changed) {
  SeenThrough carving(grid, map.camera, map.X_WC, limits.limit, margin_voxels);
  // Where no thread starts, `deferred` leaves nothing to the other.
  auto other = std::async(std::launch::async | std::launch::deferred, [&] { carving.work(); });
  add_points(map, limits, grid.geometry(), margin_voxels, evidence);
  carving.work();
  other.get();
  empty_voxels(carving.plane, votes, grid, evidence, changed);
}

void label(const std::vector<std::uint64_t>& environment, const CarvingSettings& settings, const Evidence& evidence,
           voxel::OccupancyGrid& grid, voxel::BrickMarks* changed) {
  const std::uint64_t *const occupied = grid.occupied().data(), *const solids = environment.data();
  std::uint64_t *const known_plane = grid.known().data(), *const environment_plane = grid.environment().data();
  for (std::size_t b = 0; b < evidence.bricks().size(); ++b) {
    const EvidenceBrick* brick = evidence.bricks().find(b);
    std::uint64_t differs = 0;
    for (std::size_t x = 0; x < 8; ++x) {
      const std::size_t word = 8 * b + x;
      const std::uint64_t open = occupied[word] & ~solids[word];
      std::uint64_t known = 0, solid = 0;
      if (brick && open != 0)
        for (std::size_t i = 0; i < 64; ++i) {
          const std::size_t v = 64 * x + i;
          known |= static_cast<std::uint64_t>(is_seen(*brick, v, settings)) << i;
          solid |= static_cast<std::uint64_t>(brick->solid[v] >= settings.seen_points) << i;
        }
      known &= open;
      solid = (solids[word] & occupied[word]) | (solid & ~known & open);
      differs |= (known_plane[word] ^ known) | (environment_plane[word] ^ solid);
      known_plane[word] = known;
      environment_plane[word] = solid;
    }
    if (changed && differs != 0) (*changed)[b] = 1;
  }
}

}  // namespace periplus::object_model
