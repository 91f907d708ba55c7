#include "common/object_model/log_odds.h"

#include <algorithm>
#include <cmath>

#include "common/core/error.h"
#include "common/object_model/grid_projection.h"
#include "common/object_model/image_minimum.h"
#include "common/object_model/log_odds_kernel.h"

namespace periplus::object_model {

namespace {
constexpr double kLogOddsUnit = 1024;
constexpr int kSupportReach = 2;  // [px]
}  // namespace

double LogOdds::at(const Eigen::Vector3i& v) const {
  const LogOddsBrick* brick = bricks_.find(voxel::brick_of(geometry_, v));
  return brick ? (*brick)[static_cast<std::size_t>(voxel::within_brick(v))] / kLogOddsUnit : 0;
}

void LogOdds::integrate(const DepthMap& map, const PixelLimits& limits, double focal_baseline, const CarvingRule& rule, const CarvingSettings& settings,
                        voxel::Simd simd) {
  require(focal_baseline > 0 && limits.kind.data.size() == map.depth.data.size() && limits.limit.data.size() == map.depth.data.size() &&
              map.depth.width == map.camera.width && map.depth.height == map.camera.height,
          ErrorCode::bad_size, "depth, its limits and the rig must fit the camera");
  const double h = geometry_.voxel_size;
  ImageF surface(map.camera.width, map.camera.height), free(map.camera.width, map.camera.height);
  const auto extra = static_cast<float>(settings.solid_extra_voxels * h);
  for (std::size_t i = 0; i < surface.data.size(); ++i) {
    const PixelKind kind = limits.kind.data[i];
    surface.data[i] = kind == PixelKind::surface ? map.depth.data[i] : 0.0f;
    const bool through_solid = kind == PixelKind::known_solid && limits.limit.data[i] > map.depth.data[i];
    free.data[i] = kind == PixelKind::none ? 0.0f : map.depth.data[i] + (through_solid ? extra : 0.0f);
  }
  DepthEvidence says;
  says.surface = surface.data.data();
  says.free = free.data.data();
  says.focal_px = static_cast<float>(map.camera.fx);
  says.voxel_m = static_cast<float>(h);
  says.margin_m = static_cast<float>(settings.margin_voxels * h);
  says.sigma_per_z2 = static_cast<float>(settings.log_odds.disparity_sigma_px / focal_baseline);
  says.pose_variance = static_cast<float>(rule.pose_sigma_m * rule.pose_sigma_m);
  says.hit = static_cast<float>(settings.log_odds.hit);
  says.miss = static_cast<float>(settings.log_odds.miss);
  const int least = static_cast<int>(settings.log_odds.least * kLogOddsUnit), most = static_cast<int>(settings.log_odds.most * kLogOddsUnit);

  const GridProjection projection(map.camera, map.X_WC, geometry_);
  const BlockRange depths(free);
  simd = voxel::resolve(simd);
  float change[8][kLayer];
  for_each_brick_in_view(projection, geometry_, [&](std::size_t brick, int bx, int by, int bz, const BrickView& view) {
    if (view.in_front) {
      float unused, greatest;
      depths.range(view.x0, view.y0, view.x1, view.y1, unused, greatest);
      const double z = greatest, sigma_z = says.sigma_per_z2 * z * z;
      // Nothing reaches so far: all of it is hidden.
      if (z < view.near - says.margin_m - 2 * std::hypot(sigma_z, rule.pose_sigma_m) - 1e-4) return;
    }
    bool any = false;
    for (int x = 0; x < 8; ++x) {
      layer_log_odds(projection.camera, says, 8 * bx + x, 8 * by, 8 * bz, change[x], simd);
      for (int i = 0; i < kLayer; ++i) any |= change[x][i] != 0;
    }
    if (!any) return;
    LogOddsBrick& values = bricks_.hold(brick);
    for (int i = 0; i < voxel::kBrickVoxels; ++i) {
      std::int16_t& value = values[static_cast<std::size_t>(i)];
      value = static_cast<std::int16_t>(std::clamp(value + static_cast<int>(std::lrint(change[i / kLayer][i % kLayer] * kLogOddsUnit)), least, most));
    }
  });
}

void LogOdds::label(const std::vector<std::uint64_t>& environment, const CarvingSettings& settings, const Evidence& evidence,
                    voxel::OccupancyGrid& grid, voxel::BrickMarks* changed) const {
  const auto empty_below = static_cast<int>(settings.log_odds.empty_below * kLogOddsUnit), known_above = static_cast<int>(settings.log_odds.known_above * kLogOddsUnit);
  const std::vector<std::uint64_t> all = voxel::all_voxels(grid.geometry());
  for (std::size_t b = 0; b < bricks_.size(); ++b) {
    const LogOddsBrick* brick = bricks_.find(b);
    const EvidenceBrick* counters = evidence.bricks().find(b);
    std::uint64_t differs = 0;
    for (std::size_t x = 0; x < 8; ++x) {
      const std::size_t word = 8 * b + x;
      std::uint64_t occupied = grid.occupied()[word], known = 0, solid = 0;
      if (brick) {
        std::uint64_t empty = 0;
        for (std::size_t i = 0; i < 64; ++i) {
          const std::size_t v = 64 * x + i;
          const int value = (*brick)[v];
          empty |= static_cast<std::uint64_t>(value < empty_below) << i;
          if (!counters) continue;
          known |= static_cast<std::uint64_t>(value > known_above && is_seen(*counters, v, settings)) << i;
          solid |= static_cast<std::uint64_t>(counters->solid[v] >= settings.seen_points) << i;
        }
        const std::uint64_t open = all[word] & ~environment[word] & ~empty;
        occupied = (occupied & environment[word]) | open;
        known &= open;
        solid &= open & ~known;
      }
      solid |= environment[word] & occupied;
      differs |= (grid.occupied()[word] ^ occupied) | (grid.known()[word] ^ known) | (grid.environment()[word] ^ solid);
      grid.occupied()[word] = occupied;
      grid.known()[word] = known;
      grid.environment()[word] = solid;
    }
    if (changed && differs != 0) (*changed)[b] = 1;
  }
}

DepthMap without_outliers(const DepthMap& map, double support_share, double tolerance) {
  DepthMap out = map;
  const int width = map.depth.width, height = map.depth.height;
  const auto near = static_cast<float>(tolerance), share = static_cast<float>(support_share);
  std::vector<float> shared(static_cast<std::size_t>(width)), there(static_cast<std::size_t>(width));
  for (int y = 0; y < height; ++y) {
    const float* row = &map.depth.at(0, y);
    std::fill(shared.begin(), shared.end(), 0.0f);
    std::fill(there.begin(), there.end(), 0.0f);
    for (int dy = -kSupportReach; dy <= kSupportReach; ++dy) {
      if (y + dy < 0 || y + dy >= height) continue;
      const float* other = &map.depth.at(0, y + dy);
      for (int dx = -kSupportReach; dx <= kSupportReach; ++dx) {
        if (dx == 0 && dy == 0) continue;
        for (int x = std::max(0, -dx); x < width - std::max(0, dx); ++x) {
          const float z = other[x + dx], off = z - row[x];
          const float is = z > 0 ? 1.0f : 0.0f;
          there[static_cast<std::size_t>(x)] += is;
          shared[static_cast<std::size_t>(x)] += (off <= near) & (off >= -near) ? is : 0.0f;
        }
      }
    }
    for (int x = 0; x < width; ++x) {
      if (shared[static_cast<std::size_t>(x)] >= share * there[static_cast<std::size_t>(x)] && there[static_cast<std::size_t>(x)] > 0) continue;
      out.depth.at(x, y) = 0;
      out.depth_minimum.at(x, y) = 0;
    }
  }
  return out;
}

}  // namespace periplus::object_model
