// Compiled by itself, vectorised, without fused operations (CMakeLists.txt). The body is inlined into one function per
// instruction set.
#include "common/object_model/evidence_kernel.h"

namespace periplus::object_model {
namespace {

#if defined(__x86_64__)
#define PERIPLUS_AVX2 __attribute__((target("avx2")))
#define PERIPLUS_AVX512 __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,prefer-vector-width=512")))
#endif
#define PERIPLUS_INLINE inline __attribute__((always_inline))

// Behind the measured depth, noise may have put the surface's voxel [voxels].
constexpr float kBehind = 0.3f;
// The least depth around a pixel may lie this far before its own and still be the same, slanted surface [voxels].
constexpr float kSlant = 2.5f;
constexpr float kStep = 0.5f;   // [voxels]
constexpr float kAround = 4;    // points this far outside the grid may speak for voxels in it [voxels]
constexpr std::int32_t kSurface = 1, kSolid = 2;

PERIPLUS_INLINE float least(float a, float b) { return a < b ? a : b; }
PERIPLUS_INLINE float greatest(float a, float b) { return a > b ? a : b; }
PERIPLUS_INLINE std::int32_t clamped(std::int32_t v, std::int32_t most) { return v < 0 ? 0 : v > most ? most : v; }

PERIPLUS_INLINE void run_body(const GridRays& r, int x0, int y, const float* depth, const std::uint8_t* kind, RunVoxels& out) {
  float ray[3][kRun], z[kRun], nearest[kRun];
  std::int32_t speaks[kRun], kinds[kRun], last[kRun];
  std::int32_t any = 0;
  float lower[3], upper[3];
  for (int n = 0; n < 3; ++n) {
    const float row = r.dv[n] * static_cast<float>(y) + r.d1[n];
    for (int i = 0; i < kRun; ++i) ray[n][i] = r.du[n] * static_cast<float>(x0 + i) + row;
    lower[n] = -kAround;
    upper[n] = static_cast<float>(r.size[n]) + kAround;
  }
  for (int i = 0; i < kRun; ++i) {
    kinds[i] = kind[i];
    z[i] = kinds[i] != 0 ? depth[i] : 1.0f;
    const float px = r.origin[0] + ray[0][i] * z[i], py = r.origin[1] + ray[1][i] * z[i], pz = r.origin[2] + ray[2][i] * z[i];
    const std::int32_t near = (px >= lower[0]) & (px <= upper[0]) & (py >= lower[1]) & (py <= upper[1]) & (pz >= lower[2]) & (pz <= upper[2]);
    speaks[i] = near & static_cast<std::int32_t>(kinds[i] != 0);
    any |= speaks[i];
    const float sx = static_cast<float>(r.size[0]), sy = static_cast<float>(r.size[1]), sz = static_cast<float>(r.size[2]);
    const std::int32_t in = (px >= 0) & (px < sx) & (py >= 0) & (py < sy) & (pz >= 0) & (pz < sz) & static_cast<std::int32_t>(kinds[i] == kSurface);
    const std::int32_t ix = static_cast<std::int32_t>(in != 0 ? px : 0.0f), iy = static_cast<std::int32_t>(in != 0 ? py : 0.0f), iz = static_cast<std::int32_t>(in != 0 ? pz : 0.0f);
    const std::int32_t voxel = (((ix >> 3) * r.bricks[1] + (iy >> 3)) * r.bricks[2] + (iz >> 3)) * 512 + (ix & 7) * 64 + (iy & 7) * 8 + (iz & 7);
    out.point[i] = in != 0 ? 2 * voxel : -1;
  }
  out.steps = 0;
  if (any == 0) return;

  // Least depth within a voxel's projection about the pixel: what has kept such a voxel from being emptied.
  const float widest = static_cast<float>(r.width > r.height ? r.width : r.height);
  std::int32_t radius[kRun], row[kRun];
  for (int i = 0; i < kRun; ++i) {
    nearest[i] = z[i];
    last[i] = -1;
    radius[i] = static_cast<std::int32_t>(least(greatest(r.focal_px * r.voxel_m / z[i], 1.0f), widest));
  }
  for (int dy = -1; dy <= 1; ++dy) {
    for (int i = 0; i < kRun; ++i) row[i] = clamped(y + dy * radius[i], r.height - 1) * r.width;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int i = 0; i < kRun; ++i) {
        const float m = r.minimum[row[i] + clamped(x0 + i + dx * radius[i], r.width - 1)];
        nearest[i] = m > 0 ? least(nearest[i], m) : nearest[i];
      }
    }
  }
  for (int i = 0; i < kRun; ++i) nearest[i] = greatest(nearest[i], z[i] - kSlant * r.voxel_m) - r.margin_m;

  for (int k = 0; k < kMostSteps; ++k) {
    const float ahead = (kBehind - kStep * static_cast<float>(k)) * r.voxel_m;
    std::int32_t* const step = out.step[k];
    std::int32_t more = 0;
    for (int i = 0; i < kRun; ++i) {
      const float t = z[i] + ahead;
      const std::int32_t on = static_cast<std::int32_t>(t > nearest[i]) & speaks[i];
      more |= on;
      const float px = r.origin[0] + ray[0][i] * t, py = r.origin[1] + ray[1][i] * t, pz = r.origin[2] + ray[2][i] * t;
      const float sx = static_cast<float>(r.size[0]), sy = static_cast<float>(r.size[1]), sz = static_cast<float>(r.size[2]);
      const std::int32_t in = (px >= 0) & (px < sx) & (py >= 0) & (py < sy) & (pz >= 0) & (pz < sz) & on;
      const std::int32_t ix = static_cast<std::int32_t>(in != 0 ? px : 0.0f), iy = static_cast<std::int32_t>(in != 0 ? py : 0.0f), iz = static_cast<std::int32_t>(in != 0 ? pz : 0.0f);
      const std::int32_t voxel = (((ix >> 3) * r.bricks[1] + (iy >> 3)) * r.bricks[2] + (iz >> 3)) * 512 + (ix & 7) * 64 + (iy & 7) * 8 + (iz & 7);
      const std::int32_t code = 2 * voxel + (kinds[i] == kSolid ? 1 : 0);
      step[i] = (in != 0) & (code != last[i]) ? code : -1;
      last[i] = in != 0 ? code : last[i];
    }
    if (more == 0) break;
    out.steps = k + 1;
  }
}

void run_portable(const GridRays& r, int x0, int y, const float* depth, const std::uint8_t* kind, RunVoxels& out) { run_body(r, x0, y, depth, kind, out); }
#if defined(__x86_64__)
PERIPLUS_AVX2 void run_avx2(const GridRays& r, int x0, int y, const float* depth, const std::uint8_t* kind, RunVoxels& out) { run_body(r, x0, y, depth, kind, out); }
PERIPLUS_AVX512 void run_avx512(const GridRays& r, int x0, int y, const float* depth, const std::uint8_t* kind, RunVoxels& out) { run_body(r, x0, y, depth, kind, out); }
#endif

}  // namespace

void run_voxels(const GridRays& rays, int x0, int y, const float* depth, const std::uint8_t* kind, RunVoxels& out, voxel::Simd simd) {
#if defined(__x86_64__)
  simd = voxel::resolve(simd);
  if (simd >= voxel::Simd::avx512) return run_avx512(rays, x0, y, depth, kind, out);
  if (simd == voxel::Simd::avx2) return run_avx2(rays, x0, y, depth, kind, out);
#endif
  run_portable(rays, x0, y, depth, kind, out);
}

}  // namespace periplus::object_model
