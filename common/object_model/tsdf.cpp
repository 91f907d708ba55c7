#include "common/object_model/tsdf.h"

#include <algorithm>
#include <cmath>

namespace periplus::object_model {

namespace {
// Colours are taken this close to the surface [voxels].
constexpr double kColorBand = 1.5;
// A known solid leaves this much before it untouched [voxels].
constexpr double kSolidClearance = 1.5;
}  // namespace

Tsdf::Tsdf(const voxel::GridGeometry& geometry)
    : samples_(static_cast<std::size_t>(geometry.size.x()) * geometry.size.y() * geometry.size.z()) {}

void Tsdf::integrate(const DepthMap& map, const PixelLimits& limits, const ImageU8& color, const voxel::GridGeometry& geometry,
                     double truncation) {
  const double h = geometry.voxel_size;
  const Pose X_CG = map.X_WC.inverse() * geometry.X_WG;
  const bool colored = color.channels == 3 && color.width == map.camera.width && color.height == map.camera.height;
  std::size_t i = 0;
  for (int x = 0; x < geometry.size.x(); ++x)
    for (int y = 0; y < geometry.size.y(); ++y)
      for (int z = 0; z < geometry.size.z(); ++z, ++i) {
        const Eigen::Vector3d p = X_CG * (Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * h);
        if (p.z() < 1e-3) continue;
        const Eigen::Vector2d pixel = map.camera.project(p);
        if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < map.camera.width - 0.5 && pixel.y() < map.camera.height - 0.5))
          continue;
        const int u = static_cast<int>(pixel.x() + 0.5), v = static_cast<int>(pixel.y() + 0.5);
        const PixelKind kind = limits.kind.at(u, v);
        if (kind == PixelKind::none) continue;
        const double s = map.depth.at(u, v) - p.z();
        if (s < -truncation || (kind == PixelKind::known_solid && s < kSolidClearance * h)) continue;
        TsdfSample& sample = samples_[i];
        // What lies behind the surface is seen with fading certainty.
        const float weight = s < 0 ? static_cast<float>(1 + s / truncation) : 1.0f;
        if (weight <= 0) continue;
        const float sum = sample.weight + weight;
        sample.distance = (sample.distance * sample.weight + weight * static_cast<float>(std::min(s, truncation))) / sum;
        sample.weight = sum;
        if (!colored || kind != PixelKind::surface || std::abs(s) > kColorBand * h) continue;
        const float color_sum = sample.color_weight + weight;
        const float share = weight / color_sum;
        sample.r += (static_cast<float>(color.at(u, v, 0)) - sample.r) * share;
        sample.g += (static_cast<float>(color.at(u, v, 1)) - sample.g) * share;
        sample.b += (static_cast<float>(color.at(u, v, 2)) - sample.b) * share;
        sample.color_weight = color_sum;
      }
}

}  // namespace periplus::object_model
