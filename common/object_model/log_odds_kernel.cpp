// Compiled by itself, vectorised, without fused operations (CMakeLists.txt). The body is inlined into one function per
// instruction set.
#include "common/object_model/log_odds_kernel.h"

#include <cmath>

namespace periplus::object_model {
namespace {

#if defined(__x86_64__)
#define PERIPLUS_AVX2 __attribute__((target("avx2")))
#define PERIPLUS_AVX512 __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,prefer-vector-width=512")))
#endif
#define PERIPLUS_INLINE inline __attribute__((always_inline))

constexpr float kNear = 1e-3f;  // [m]
constexpr int kPlaces = 9;

PERIPLUS_INLINE float unit(float v) { return v < 0 ? 0.0f : v > 1 ? 1.0f : v; }
PERIPLUS_INLINE std::int32_t clamped(std::int32_t v, std::int32_t most) { return v < 0 ? 0 : v > most ? most : v; }

PERIPLUS_INLINE void log_odds_body(const GridCamera& c, const DepthEvidence& e, int x, int y0, int z0, float* out) {
  const float fx = static_cast<float>(x) + 0.5f, width = static_cast<float>(c.width) - 0.5f, height = static_cast<float>(c.height) - 0.5f;
  const float a = c.m[0][0] * fx + c.m[0][3], b = c.m[1][0] * fx + c.m[1][3], w = c.m[2][0] * fx + c.m[2][3];
  float u[kLayer], v[kLayer], depth[kLayer], step[kLayer], sum[kLayer];
  std::int32_t in[kLayer];
  for (int i = 0; i < kLayer; ++i) {
    const float fy = static_cast<float>(y0 + (i >> 3)) + 0.5f, fz = static_cast<float>(z0 + (i & 7)) + 0.5f;
    depth[i] = (w + c.m[2][1] * fy) + c.m[2][2] * fz;
    const float inverse = 1.0f / depth[i];
    const float pu = ((a + c.m[0][1] * fy) + c.m[0][2] * fz) * inverse, pv = ((b + c.m[1][1] * fy) + c.m[1][2] * fz) * inverse;
    in[i] = (depth[i] > kNear) & (pu > -0.5f) & (pv > -0.5f) & (pu < width) & (pv < height);
    u[i] = in[i] != 0 ? pu : 0.0f;
    v[i] = in[i] != 0 ? pv : 0.0f;
    const float third = e.focal_px * e.voxel_m * inverse / 3;
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

void log_odds_portable(const GridCamera& c, const DepthEvidence& e, int x, int y, int z, float* out) { log_odds_body(c, e, x, y, z, out); }
#if defined(__x86_64__)
PERIPLUS_AVX2 void log_odds_avx2(const GridCamera& c, const DepthEvidence& e, int x, int y, int z, float* out) { log_odds_body(c, e, x, y, z, out); }
PERIPLUS_AVX512 void log_odds_avx512(const GridCamera& c, const DepthEvidence& e, int x, int y, int z, float* out) { log_odds_body(c, e, x, y, z, out); }
#endif

}  // namespace

void layer_log_odds(const GridCamera& camera, const DepthEvidence& map, int x, int y0, int z0, float* out, voxel::Simd simd) {
#if defined(__x86_64__)
  simd = voxel::resolve(simd);
  if (simd >= voxel::Simd::avx512) return log_odds_avx512(camera, map, x, y0, z0, out);
  if (simd == voxel::Simd::avx2) return log_odds_avx2(camera, map, x, y0, z0, out);
#endif
  log_odds_portable(camera, map, x, y0, z0, out);
}

}  // namespace periplus::object_model
