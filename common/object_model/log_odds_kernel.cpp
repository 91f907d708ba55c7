#include "common/object_model/log_odds_kernel.h"

#include <cmath>

#include "common/object_model/grid_camera_inline.h"
#include "common/voxel/simd_function.h"

namespace periplus::object_model {
namespace {

constexpr int kPlaces = 9;

PERIPLUS_INLINE float unit(float v) { return v < 0 ? 0.0f : v > 1 ? 1.0f : v; }
PERIPLUS_INLINE std::int32_t clamped(std::int32_t v, std::int32_t most) { return v < 0 ? 0 : v > most ? most : v; }

PERIPLUS_INLINE void log_odds_body(const GridCamera& c, const DepthEvidence& e, int x, int y0, int z0, float* out) {
  const LayerView view(c, x);
  float u[kLayer], v[kLayer], depth[kLayer], step[kLayer], sum[kLayer];
  std::int32_t in[kLayer];
  for (int i = 0; i < kLayer; ++i) {
    float pu, pv;
    in[i] = view.center(c, y0 + (i >> 3), z0 + (i & 7), pu, pv, depth[i]);
    u[i] = in[i] != 0 ? pu : 0.0f;
    v[i] = in[i] != 0 ? pv : 0.0f;
    const float third = e.focal_px * e.voxel_m / (3 * depth[i]);
    step[i] = in[i] != 0 ? (third < 16.0f ? third : 16.0f) : 0.0f;
    sum[i] = 0;
  }
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int i = 0; i < kLayer; ++i) {
        const std::int32_t column = clamped(static_cast<std::int32_t>(u[i] + static_cast<float>(dx) * step[i] + 0.5f), c.width - 1);
        const std::int32_t row = clamped(static_cast<std::int32_t>(v[i] + static_cast<float>(dy) * step[i] + 0.5f), c.height - 1);
        const float surface = e.surface[row * c.width + column], free = e.free[row * c.width + column];
        const float sigma_z = free * free * e.sigma_per_z2, fade = 2 * std::sqrt(sigma_z * sigma_z + e.pose_variance) + 1e-5f;
        const float before = free - depth[i] - e.margin_m, off = surface - depth[i], beyond = (off < 0 ? -off : off) - e.margin_m;
        const float missed = free > 0 ? unit(before / fade) : 0.0f, hit = surface > 0 ? 1 - unit(beyond / fade) : 0.0f;
        sum[i] += e.miss * missed + e.hit * hit;
      }
    }
  }
  for (int i = 0; i < kLayer; ++i) out[i] = in[i] != 0 ? sum[i] / kPlaces : 0.0f;
}

PERIPLUS_SIMD_FUNCTION(void, log_odds, (const GridCamera& c, const DepthEvidence& e, int x, int y, int z, float* out), (c, e, x, y, z, out))

}  // namespace

void layer_log_odds(const GridCamera& camera, const DepthEvidence& map, int x, int y0, int z0, float* out, voxel::Simd simd) {
  log_odds_for(simd)(camera, map, x, y0, z0, out);
}

}  // namespace periplus::object_model
