#include "common/object_model/tsdf.h"

#include <algorithm>
#include <cmath>

#include "common/object_model/grid_projection.h"
#include "common/object_model/image_minimum.h"

namespace periplus::object_model {

namespace {

// Colours are taken this close to the surface [voxels].
constexpr double kColorBand = 1.5;
// A known solid leaves this much before it untouched [voxels].
constexpr double kSolidClearance = 1.5;
constexpr float kFarthest = 1e9f;

// Depths that say something; 0 where there is none.
ImageF speaking(const DepthMap& map, const PixelLimits& limits) {
  ImageF out(map.camera.width, map.camera.height);
  for (std::size_t i = 0; i < out.data.size(); ++i) out.data[i] = limits.kind.data[i] != PixelKind::none ? map.depth.data[i] : 0.0f;
  return out;
}

}  // namespace

TsdfSample Tsdf::at(const Eigen::Vector3i& v) const {
  const std::size_t at = voxel::brick_of(geometry_, v);
  const PackedTsdfBrick* brick = bricks_.find(at);
  return brick ? brick->at(voxel::within_brick(v)) : free_[at];
}

void Tsdf::set(const Eigen::Vector3i& v, const TsdfSample& sample) {
  const std::size_t at = voxel::brick_of(geometry_, v);
  TsdfBrick samples;
  unpack(at, samples);
  samples[static_cast<std::size_t>(voxel::within_brick(v))] = sample;
  bricks_.hold(at) = PackedTsdfBrick(samples);
}

void Tsdf::unpack(std::size_t brick, TsdfBrick& samples) const {
  if (const PackedTsdfBrick* held = bricks_.find(brick)) return held->unpack(samples);
  const auto inside = voxel::brick_voxels(geometry_, brick);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = inside[i / 64] >> i % 64 & 1 ? free_[brick] : TsdfSample{};
}

bool Tsdf::operator==(const Tsdf& other) const {
  if (bricks_.size() != other.bricks_.size()) return false;
  TsdfBrick mine, theirs;
  for (std::size_t b = 0; b < bricks_.size(); ++b) {
    if (!bricks_.find(b) && !other.bricks_.find(b)) {
      if (!(free_[b] == other.free_[b])) return false;
      continue;
    }
    unpack(b, mine);
    other.unpack(b, theirs);
    if (mine != theirs) return false;
  }
  return true;
}

void Tsdf::integrate(const DepthMap& map, const PixelLimits& limits, const ImageU8& color, double truncation, voxel::Simd simd) {
  const double h = geometry_.voxel_size;
  const bool colored = color.channels == 3 && color.width == map.camera.width && color.height == map.camera.height;
  const GridProjection projection(map.camera, map.X_WC, geometry_);
  const ImageF depths = speaking(map, limits);
  const BlockRange ranges(depths);
  simd = voxel::resolve(simd);
  const auto most = static_cast<float>(truncation), clearance = static_cast<float>(kSolidClearance * h), band = static_cast<float>(kColorBand * h);
  LayerPixels pixels[8];
  TsdfBrick samples;
  for_each_brick_in_view(projection, geometry_, [&](std::size_t brick, int bx, int by, int bz, const BrickView& view) {
    float least = 0, greatest = kFarthest;
    if (view.in_front) ranges.range(view.x0, view.y0, view.x1, view.y1, least, greatest);
    if (greatest < static_cast<float>(view.near) - most) return;  // all of it is far behind what was seen
    if (view.inside && least > static_cast<float>(view.far) + most && !bricks_.find(brick)) {
      TsdfSample& free = free_[brick];
      free.distance = (free.distance * free.weight + most) / (free.weight + 1);
      free.weight += 1;
      return;
    }
    const auto voxels = voxel::brick_voxels(geometry_, brick);
    bool any = false;
    for (int x = 0; x < 8; ++x) {
      layer_pixels(projection.camera, 8 * bx + x, 8 * by, 8 * bz, pixels[x], simd);
      const std::uint64_t inside = voxels[static_cast<std::size_t>(x)];
      for (int i = 0; i < kLayer; ++i) {
        std::int32_t& pixel = pixels[x].pixel[i];
        const auto at = static_cast<std::size_t>(std::max(pixel, 0));
        const float s = depths.data[at] - pixels[x].depth[i];
        const bool says = (inside >> i & 1) && pixel >= 0 && depths.data[at] > 0 && s > -most &&
                          (s >= clearance || limits.kind.data[at] == PixelKind::surface);
        pixel = says ? pixel : -1;
        any |= says;
      }
    }
    if (!any) return;
    unpack(brick, samples);
    for (int x = 0; x < 8; ++x) {
      for (int i = 0; i < kLayer; ++i) {
        const std::int32_t pixel = pixels[x].pixel[i];
        if (pixel < 0) continue;
        const auto at = static_cast<std::size_t>(pixel);
        const PixelKind kind = limits.kind.data[at];
        const float s = depths.data[at] - pixels[x].depth[i];
        TsdfSample& sample = samples[static_cast<std::size_t>(64 * x + i)];
        // What lies behind the surface is seen with fading certainty.
        const float weight = s < 0 ? 1 + s / most : 1.0f;
        const float sum = sample.weight + weight;
        sample.distance = (sample.distance * sample.weight + weight * std::min(s, most)) / sum;
        sample.weight = sum;
        if (!colored || kind != PixelKind::surface || std::abs(s) > band) continue;
        const float color_sum = sample.color_weight + weight, share = weight / color_sum;
        sample.r += (static_cast<float>(color.data[3 * at]) - sample.r) * share;
        sample.g += (static_cast<float>(color.data[3 * at + 1]) - sample.g) * share;
        sample.b += (static_cast<float>(color.data[3 * at + 2]) - sample.b) * share;
        sample.color_weight = color_sum;
      }
    }
    bricks_.hold(brick) = PackedTsdfBrick(samples);
  });
}

}  // namespace periplus::object_model
