// A signed distance field that keeps and visits every voxel: what Tsdf must give to the bit, however it keeps its samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/object_model/grid_projection.h"
#include "common/object_model/tsdf.h"

namespace periplus::object_model::testing {

class DenseTsdf {
 public:
  explicit DenseTsdf(const voxel::GridGeometry& geometry)
      : geometry_(geometry), samples_(static_cast<std::size_t>(geometry.size.x()) * geometry.size.y() * geometry.size.z()) {}

  const TsdfSample& at(const Eigen::Vector3i& v) const { return samples_[voxel::voxel_index(geometry_, v)]; }

  void integrate(const DepthMap& map, const PixelLimits& limits, const ImageU8& color, double truncation) {
    const GridProjection projection(map.camera, map.X_WC, geometry_);
    const auto h = static_cast<float>(geometry_.voxel_size), most = static_cast<float>(truncation);
    LayerPixels pixels;
    for (int x = 0; x < geometry_.size.x(); ++x)
      for (int y0 = 0; y0 < geometry_.size.y(); y0 += 8)
        for (int z0 = 0; z0 < geometry_.size.z(); z0 += 8) {
          layer_pixels(projection.camera, x, y0, z0, pixels, voxel::Simd::portable);
          for (int i = 0; i < kLayer; ++i) {
            const Eigen::Vector3i v(x, y0 + i / 8, z0 + i % 8);
            if (!geometry_.contains(v) || pixels.pixel[i] < 0) continue;
            const auto at = static_cast<std::size_t>(pixels.pixel[i]);
            if (limits.kind.data[at] == PixelKind::none || map.depth.data[at] <= 0) continue;
            const float s = map.depth.data[at] - pixels.depth[i];
            if (s <= -most || (limits.kind.data[at] == PixelKind::known_solid && s < 1.5f * h)) continue;
            TsdfSample& sample = samples_[voxel::voxel_index(geometry_, v)];
            const float weight = s < 0 ? 1 + s / most : 1.0f, sum = sample.weight + weight;
            sample.distance = (sample.distance * sample.weight + weight * std::min(s, most)) / sum;
            sample.weight = sum;
            if (color.empty() || limits.kind.data[at] != PixelKind::surface || std::abs(s) > 1.5f * h) continue;
            const float color_sum = sample.color_weight + weight, share = weight / color_sum;
            sample.r += (static_cast<float>(color.data[3 * at]) - sample.r) * share;
            sample.g += (static_cast<float>(color.data[3 * at + 1]) - sample.g) * share;
            sample.b += (static_cast<float>(color.data[3 * at + 2]) - sample.b) * share;
            sample.color_weight = color_sum;
          }
        }
  }

 private:
  voxel::GridGeometry geometry_;
  std::vector<TsdfSample> samples_;
};

}  // namespace periplus::object_model::testing
