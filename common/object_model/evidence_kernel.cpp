#include "common/object_model/evidence_kernel.h"

#include "common/voxel/simd_function.h"

namespace periplus::object_model {
namespace {

// The least depth around a pixel may lie this far before its own and still be the same, slanted surface [voxels].
constexpr float kSlant = 2.5f;
// Steps: the first as far behind the depth as it may truly lie, as no ray reaches what is further; the others towards the camera [voxels].
constexpr float kStep = 0.5f, kFirstStep = 0.2f, kMostBehind = 0.5f;
constexpr float kAround = 4;    // points this far outside the grid may speak for voxels in it [voxels]
constexpr std::int32_t kFewRadii = 3;
constexpr int kBeside = 16;     // pixels whose steps are made together
constexpr std::int32_t kSurface = 1, kSolid = 2;

PERIPLUS_INLINE float least(float a, float b) { return a < b ? a : b; }
PERIPLUS_INLINE float greatest(float a, float b) { return a > b ? a : b; }
PERIPLUS_INLINE std::int32_t clamped(std::int32_t v, std::int32_t most) { return v < 0 ? 0 : v > most ? most : v; }

struct Voxel {
  std::int32_t inside, number;  // 1 within the grid, else 0; 512 times the brick and the place within it
};

PERIPLUS_INLINE Voxel voxel_at(const GridRays& r, float x, float y, float z) {
  const float sx = static_cast<float>(r.size[0]), sy = static_cast<float>(r.size[1]), sz = static_cast<float>(r.size[2]);
  const std::int32_t in = (x >= 0) & (x < sx) & (y >= 0) & (y < sy) & (z >= 0) & (z < sz);
  // What is not inside may be no number at all: 0 then, before it becomes an integer.
  const std::int32_t i = static_cast<std::int32_t>(in != 0 ? x : 0.0f), j = static_cast<std::int32_t>(in != 0 ? y : 0.0f), k = static_cast<std::int32_t>(in != 0 ? z : 0.0f);
  return {in, (((i >> 3) * r.bricks[1] + (j >> 3)) * r.bricks[2] + (k >> 3)) * 512 + (i & 7) * 64 + (j & 7) * 8 + (k & 7)};
}

PERIPLUS_INLINE RunBits bits_of(const std::int32_t* codes) {
  std::uint32_t lower = 1, upper = 0, lower_voxels = 0, upper_voxels = 0;
  for (int i = 1; i < 32; ++i) lower |= static_cast<std::uint32_t>(codes[i] != codes[i - 1]) << i;
  for (int i = 0; i < 32; ++i) upper |= static_cast<std::uint32_t>(codes[32 + i] != codes[31 + i]) << i;
  for (int i = 0; i < 32; ++i) lower_voxels |= static_cast<std::uint32_t>(codes[i] >= 0) << i;
  for (int i = 0; i < 32; ++i) upper_voxels |= static_cast<std::uint32_t>(codes[32 + i] >= 0) << i;
  const std::uint64_t changes = static_cast<std::uint64_t>(upper) << 32 | lower;
  return {changes, changes & (static_cast<std::uint64_t>(upper_voxels) << 32 | lower_voxels)};
}
static_assert(kRun == 64);

PERIPLUS_INLINE void run_body(const GridRays& rays, int x0, int y, const float* depth, const float* sigma, const std::uint8_t* kind, RunVoxels& out) {
  const GridRays r = rays;  // where no store can change it
  float ray[3][kRun], z[kRun], farthest[kRun], nearest[kRun];
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
  }
  out.steps = 0;
  if (any == 0) return;
  for (int i = 0; i < kRun; ++i) {
    const Voxel at = voxel_at(r, r.origin[0] + ray[0][i] * z[i], r.origin[1] + ray[1][i] * z[i], r.origin[2] + ray[2][i] * z[i]);
    const std::int32_t in = -(at.inside & static_cast<std::int32_t>(kinds[i] == kSurface));
    out.point[i] = (2 * at.number & in) | ~in;
  }
  out.point_bits = bits_of(out.point);

  // Least depth within a voxel's projection about the pixel: what has kept such a voxel from being emptied.
  const float widest = static_cast<float>(r.width > r.height ? r.width : r.height);
  std::int32_t radius[kRun], row[kRun];
  for (int i = 0; i < kRun; ++i) {
    nearest[i] = z[i];
    last[i] = -1;
    radius[i] = static_cast<std::int32_t>(least(greatest(r.focal_px * r.voxel_m / z[i], 1.0f), widest));
  }
  // Where few radii occur and no window leaves the rows' ends, the pixels of a window stand beside each other.
  std::int32_t smallest = 1 << 30, largest = 0;
  for (int i = 0; i < kRun; ++i) {
    const std::int32_t silent = speaks[i] - 1, low = radius[i] | (silent & 1 << 30), high = radius[i] & ~silent;
    smallest = smallest < low ? smallest : low;
    largest = largest > high ? largest : high;
  }
  if (largest - smallest < kFewRadii && x0 - largest >= 0 && x0 + kRun + largest <= r.width) {
    for (std::int32_t of = smallest; of <= largest; ++of) {
      float around[kRun];
      for (int i = 0; i < kRun; ++i) around[i] = z[i];
      for (int dy = -1; dy <= 1; ++dy) {
        const float* beside = r.minimum + clamped(y + dy * of, r.height - 1) * r.width + x0;
        for (int dx = -1; dx <= 1; ++dx) {
          for (int i = 0; i < kRun; ++i) {
            const float m = beside[i + dx * of];
            around[i] = m > 0 ? least(around[i], m) : around[i];
          }
        }
      }
      for (int i = 0; i < kRun; ++i) nearest[i] = radius[i] == of ? around[i] : nearest[i];
    }
  } else {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int i = 0; i < kRun; ++i) row[i] = clamped(y + dy * radius[i], r.height - 1) * r.width;
      for (int dx = -1; dx <= 1; ++dx) {
        for (int i = 0; i < kRun; ++i) {
          const float m = r.minimum[row[i] + clamped(x0 + i + dx * radius[i], r.width - 1)];
          nearest[i] = m > 0 ? least(nearest[i], m) : nearest[i];
        }
      }
    }
  }
  for (int i = 0; i < kRun; ++i) {
    farthest[i] = z[i] + least(sigma[i], kMostBehind * r.voxel_m);
    nearest[i] = greatest(nearest[i], z[i] - kSlant * r.voxel_m) - r.margin_m;
  }

  // Some pixels at a time, as some rays are longer than others.
  std::int32_t most = 0, steps[kRun / kBeside];
  for (int begin = 0; begin < kRun; begin += kBeside) {
    std::int32_t k = 0;
    for (; k < kMostSteps; ++k) {
      const float ahead = k == 0 ? 0.0f : (kStep - kFirstStep - kStep * static_cast<float>(k)) * r.voxel_m;
      const float* const from = k == 0 ? farthest : z;
      std::int32_t* const step = out.step[k];
      std::int32_t more = 0;
      for (int i = begin; i < begin + kBeside; ++i) {
        const float t = from[i] + ahead;
        const std::int32_t on = static_cast<std::int32_t>(t > nearest[i]) & speaks[i];
        more |= on;
        const float px = r.origin[0] + ray[0][i] * t, py = r.origin[1] + ray[1][i] * t, pz = r.origin[2] + ray[2][i] * t;
        const Voxel at = voxel_at(r, px, py, pz);
        // With masks: the compiler makes branches of conditions here, and no vectors.
        const std::int32_t code = 2 * at.number + static_cast<std::int32_t>(kinds[i] == kSolid), in = -(at.inside & on);
        const std::int32_t fresh = in & -static_cast<std::int32_t>(code != last[i]);
        step[i] = (code & fresh) | ~fresh;
        last[i] = (code & in) | (last[i] & ~in);
      }
      if (more == 0) break;
    }
    steps[begin / kBeside] = k;
    most = most > k ? most : k;
  }
  for (int begin = 0; begin < kRun; begin += kBeside) {
    for (int k = steps[begin / kBeside]; k < most; ++k) {
      for (int i = begin; i < begin + kBeside; ++i) out.step[k][i] = -1;
    }
  }
  for (int k = 0; k < most; ++k) out.step_bits[k] = bits_of(out.step[k]);
  out.steps = most;
}

PERIPLUS_SIMD_FUNCTION(void, run, (const GridRays& r, int x0, int y, const float* depth, const float* sigma, const std::uint8_t* kind, RunVoxels& out),
                       (r, x0, y, depth, sigma, kind, out))

}  // namespace

void run_voxels(const GridRays& rays, int x0, int y, const float* depth, const float* sigma, const std::uint8_t* kind, RunVoxels& out, voxel::Simd simd) {
  run_for(simd)(rays, x0, y, depth, sigma, kind, out);
}

}  // namespace periplus::object_model
