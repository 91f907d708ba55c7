#include "services/nbv_planner/visible_list_kernel.h"

#include "common/voxel/simd_function.h"

namespace periplus::nbv {
namespace {

PERIPLUS_INLINE float absolute(float v) { return v < 0 ? -v : v; }

PERIPLUS_INLINE std::int32_t sum_body(const PointArrays& p, const WindowPlanes& w) {
  const float *X = p.x, *Y = p.y, *Z = p.z;
  const std::int32_t* W = p.weight;
  const float r0 = w.right[0], r1 = w.right[1], r2 = w.right[2], d0 = w.down[0], d1 = w.down[1], d2 = w.down[2];
  const float f0 = w.forward[0], f1 = w.forward[1], f2 = w.forward[2];
  const float th = w.tan_horizontal, tv = w.tan_vertical, half = w.half_baseline, near = w.depth_min, far = w.depth_max;
  std::int32_t sum = 0;
  const int n = p.count;
  for (int i = 0; i < n; ++i) {
    const float x = X[i], y = Y[i], z = Z[i];
    const float a = absolute(r0 * x + r1 * y + r2 * z), b = absolute(d0 * x + d1 * y + d2 * z), c = f0 * x + f1 * y + f2 * z;
    const int in = (a <= th * c - half) & (b <= tv * c) & (c >= near) & (c <= far);
    sum += W[i] & -in;
  }
  return sum;
}

// atan on [0, 1] (Abramowitz and Stegun 4.4.49).
PERIPLUS_INLINE float arc(float t) {
  const float s = t * t;
  return t * (0.9998660f + s * (-0.3302995f + s * (0.1801410f + s * (-0.0851330f + s * 0.0208351f))));
}

PERIPLUS_INLINE void angles_body(const PointArrays& p, float scale, float* azimuth, float* elevation) {
  constexpr float kPi = 3.14159265f, kHalf = 1.57079633f;
  const float *X = p.x, *Y = p.y, *Z = p.z;
  const int n = p.count;
  for (int i = 0; i < n; ++i) {
    const float x = X[i], y = Y[i], z = Z[i];
    const float ax = absolute(x), ay = absolute(y), az = absolute(z);
    const float most = ax > ay ? ax : ay, least = ax > ay ? ay : ax;
    float a = arc(least / (most + 1e-9f));
    a = ay > ax ? kHalf - a : a;
    a = x < 0 ? kPi - a : a;
    a = y < 0 ? -a : a;
    const float flat = __builtin_sqrtf(x * x + y * y);
    const float more = az > flat ? az : flat, less = az > flat ? flat : az;
    float e = arc(less / (more + 1e-9f));
    e = az > flat ? kHalf - e : e;
    e = z < 0 ? -e : e;
    azimuth[i] = (a + kPi) * scale;
    elevation[i] = e * scale;
  }
}

PERIPLUS_INLINE void place_body(const std::uint32_t* index, int count, const VoxelPlacement& q, float* x, float* y, float* z) {
  const double per_row = 1.0 / q.size_z, per_layer = 1.0 / (static_cast<double>(q.size_y) * q.size_z);
  const std::int32_t ny = q.size_y, nz = q.size_z;
  const float m00 = q.m[0][0], m01 = q.m[0][1], m02 = q.m[0][2], m03 = q.m[0][3];
  const float m10 = q.m[1][0], m11 = q.m[1][1], m12 = q.m[1][2], m13 = q.m[1][3];
  const float m20 = q.m[2][0], m21 = q.m[2][1], m22 = q.m[2][2], m23 = q.m[2][3];
  for (int n = 0; n < count; ++n) {
    const std::int32_t at = static_cast<std::int32_t>(index[n]);
    // Divisions by multiplication: half a voxel from the next whole number, far more than they round.
    const std::int32_t row = static_cast<std::int32_t>((at + 0.5) * per_row), i = static_cast<std::int32_t>((at + 0.5) * per_layer);
    const float fi = static_cast<float>(i), fj = static_cast<float>(row - i * ny), fk = static_cast<float>(at - row * nz);
    x[n] = m00 * fi + m01 * fj + m02 * fk + m03;
    y[n] = m10 * fi + m11 * fj + m12 * fk + m13;
    z[n] = m20 * fi + m21 * fj + m22 * fk + m23;
  }
}

PERIPLUS_SIMD_FUNCTION(std::int32_t, sum, (const PointArrays& p, const WindowPlanes& w), (p, w))
PERIPLUS_SIMD_FUNCTION(void, angles, (const PointArrays& p, float scale, float* azimuth, float* elevation), (p, scale, azimuth, elevation))
PERIPLUS_SIMD_FUNCTION(void, place, (const std::uint32_t* index, int count, const VoxelPlacement& q, float* x, float* y, float* z), (index, count, q, x, y, z))

}  // namespace

std::int32_t window_sum(const PointArrays& points, const WindowPlanes& window, voxel::Simd simd) { return sum_for(simd)(points, window); }

void point_angles(const PointArrays& points, float cells_per_radian, float* azimuth, float* elevation, voxel::Simd simd) {
  angles_for(simd)(points, cells_per_radian, azimuth, elevation);
}

void place_voxels(const std::uint32_t* index, int count, const VoxelPlacement& placement, float* x, float* y, float* z,
                  voxel::Simd simd) {
  place_for(simd)(index, count, placement, x, y, z);
}

}  // namespace periplus::nbv
