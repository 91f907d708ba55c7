#include "common/object_model/carving_kernel.h"

#include <limits>

#include "common/object_model/grid_camera_inline.h"
#include "common/voxel/simd_function.h"

namespace periplus::object_model {
namespace {

constexpr float kRounding = 1e-6f;  // of a sum of a few products in single precision, as a share of its largest terms

PERIPLUS_INLINE float absolute(float v) { return v < 0 ? -v : v; }
PERIPLUS_INLINE float least(float a, float b) { return a < b ? a : b; }
PERIPLUS_INLINE float greatest(float a, float b) { return a > b ? a : b; }
PERIPLUS_INLINE std::int32_t least(std::int32_t a, std::int32_t b) { return a < b ? a : b; }
PERIPLUS_INLINE std::int32_t greatest(std::int32_t a, std::int32_t b) { return a > b ? a : b; }

PERIPLUS_INLINE bool limits_body(const float* __restrict depth, const float* __restrict minimum, std::int32_t pixels, float* __restrict limit,
                                 std::uint8_t* __restrict measured) {
  std::int32_t all = 1;
  for (std::int32_t i = 0; i < pixels; ++i) {
    const float z = depth[i], m = minimum[i];
    const std::int32_t is = (z > 0) & (m > 0) & (z <= std::numeric_limits<float>::max());
    limit[i] = is != 0 ? least(z, m) : 0.0f;
    measured[i] = static_cast<std::uint8_t>(is);
    all &= is;
  }
  return all != 0;
}

PERIPLUS_INLINE void corners_body(const GridCamera& camera, int x, int y0, int z0, PlaneCorners& out) {
  const GridCamera c = camera;  // where no store can change it
  const float fx = static_cast<float>(x), a = c.m[0][0] * fx + c.m[0][3], b = c.m[1][0] * fx + c.m[1][3], w = c.m[2][0] * fx + c.m[2][3];
  float u[2][kPlane], v[2][kPlane], depth[2][kPlane];
  for (int dz = 0; dz < 2; ++dz) {
    for (int i = 0; i < kPlane; ++i) {
      const float fy = static_cast<float>(y0 + (i >> 3)), fz = static_cast<float>(z0 + dz + (i & 7));
      depth[dz][i] = (w + c.m[2][1] * fy) + c.m[2][2] * fz;
      const float inverse = 1.0f / depth[dz][i];
      u[dz][i] = ((a + c.m[0][1] * fy) + c.m[0][2] * fz) * inverse;
      v[dz][i] = ((b + c.m[1][1] * fy) + c.m[1][2] * fz) * inverse;
    }
  }
  for (int i = 0; i < kPlane; ++i) {
    out.u0[i] = least(u[0][i], u[1][i]);
    out.u1[i] = greatest(u[0][i], u[1][i]);
    out.v0[i] = least(v[0][i], v[1][i]);
    out.v1[i] = greatest(v[0][i], v[1][i]);
    out.near[i] = least(depth[0][i], depth[1][i]);
  }
}

PERIPLUS_INLINE float least_of(const float* lower, const float* upper, int i) { return least(least(lower[i], lower[i + 8]), least(upper[i], upper[i + 8])); }
PERIPLUS_INLINE float greatest_of(const float* lower, const float* upper, int i) {
  return greatest(greatest(lower[i], lower[i + 8]), greatest(upper[i], upper[i + 8]));
}

PERIPLUS_INLINE void rectangles_body(const GridCamera& c, int x, int y0, int z0, const PlaneCorners& lower, const PlaneCorners& upper, LayerRectangles& out) {
  const float w1 = c.m[2][1], w2 = c.m[2][2];
  float sum[3];  // of the terms of each row, at most
  for (int k = 0; k < 3; ++k) {
    sum[k] = ((absolute(c.m[k][0]) * static_cast<float>(x + 1) + absolute(c.m[k][1]) * static_cast<float>(y0 + 8)) + absolute(c.m[k][2]) * static_cast<float>(z0 + 8)) + absolute(c.m[k][3]);
  }
  const float rounding = kRounding * (greatest(sum[0], sum[1]) + static_cast<float>(greatest(c.width, c.height)) * sum[2]);  // of u w and v w
  const float half = 0.5f * (c.m[2][0] + w1 + w2), first = c.m[2][0] * static_cast<float>(x) + c.m[2][3];
  const float right = static_cast<float>(c.width) - 0.5f, bottom = static_cast<float>(c.height) - 0.5f;
  for (int i = 0; i < kLayer; ++i) {
    const float fy = static_cast<float>(y0 + (i >> 3)), fz = static_cast<float>(z0 + (i & 7));
    const float near = least_of(lower.near, upper.near, i);
    out.depth[i] = (((first + w1 * fy) + w2 * fz) + half) + kRounding * sum[2];
    const float slack = rounding / near, l = least_of(lower.u0, upper.u0, i) - slack, r = greatest_of(lower.u1, upper.u1, i) + slack;
    const float t = least_of(lower.v0, upper.v0, i) - slack, b = greatest_of(lower.v1, upper.v1, i) + slack;
    const std::int32_t in = (near > kNearestDepth) & (l >= -0.5f) & (t >= -0.5f) & (r < right) & (b < bottom);
    out.inside[i] = in;
    // What is not inside may be no number at all: 0 then, before it becomes an integer.
    out.x0[i] = static_cast<std::int32_t>(in != 0 ? l + 0.5f : 0.0f);
    out.x1[i] = static_cast<std::int32_t>(in != 0 ? r + 0.5f : 0.0f);
    out.y0[i] = static_cast<std::int32_t>(in != 0 ? t + 0.5f : 0.0f);
    out.y1[i] = static_cast<std::int32_t>(in != 0 ? b + 0.5f : 0.0f);
  }
  std::int32_t shortest = 1 << 30, longest_x = 0, longest_y = 0;
  for (int i = 0; i < kLayer; ++i) {
    const std::int32_t across = out.x1[i] - out.x0[i] + 1, down = out.y1[i] - out.y0[i] + 1;
    shortest = least(shortest, out.inside[i] != 0 ? least(across, down) : 1 << 30);
    longest_x = greatest(longest_x, across);
    longest_y = greatest(longest_y, down);
  }
  out.shortest = shortest == 1 << 30 ? 0 : shortest;
  out.longest_x = longest_x;
  out.longest_y = longest_y;
}

PERIPLUS_INLINE std::uint64_t seen_body(const LayerRectangles& q, const float* squares, int width, int side, float margin) {
  float found[kLayer];
  for (int i = 0; i < kLayer; ++i) found[i] = 1e9f;
  // Squares beside each other, the last of a row or column moved back to the rectangle's end.
  for (int down = 0; down < q.longest_y; down += side) {
    for (int across = 0; across < q.longest_x; across += side) {
      for (int i = 0; i < kLayer; ++i) {
        const std::int32_t x = greatest(least(q.x0[i] + across, q.x1[i] - side + 1), 0), y = greatest(least(q.y0[i] + down, q.y1[i] - side + 1), 0);
        found[i] = least(found[i], squares[y * width + x]);
      }
      std::int32_t open = 0;
      for (int i = 0; i < kLayer; ++i) open |= static_cast<std::int32_t>(found[i] > q.depth[i] + margin) & q.inside[i];
      if (open == 0) return 0;
    }
  }
  std::uint32_t lower = 0, upper = 0;
  for (int i = 0; i < 32; ++i) lower |= static_cast<std::uint32_t>((found[i] > q.depth[i] + margin) & q.inside[i]) << i;
  for (int i = 0; i < 32; ++i) upper |= static_cast<std::uint32_t>((found[32 + i] > q.depth[32 + i] + margin) & q.inside[32 + i]) << i;
  return static_cast<std::uint64_t>(upper) << 32 | lower;
}

PERIPLUS_INLINE void pixels_body(const GridCamera& c, int x, int y0, int z0, LayerPixels& out) {
  const LayerView view(c, x);
  for (int i = 0; i < kLayer; ++i) {
    float u, v;
    const std::int32_t in = view.center(c, y0 + (i >> 3), z0 + (i & 7), u, v, out.depth[i]);
    const std::int32_t column = static_cast<std::int32_t>(in != 0 ? u + 0.5f : 0.0f), row = static_cast<std::int32_t>(in != 0 ? v + 0.5f : 0.0f);
    out.pixel[i] = in != 0 ? row * c.width + column : -1;
  }
}

PERIPLUS_SIMD_FUNCTION(bool, limits, (const float* depth, const float* minimum, std::int32_t pixels, float* limit, std::uint8_t* measured),
                       (depth, minimum, pixels, limit, measured))
PERIPLUS_SIMD_FUNCTION(void, pixels, (const GridCamera& c, int x, int y, int z, LayerPixels& out), (c, x, y, z, out))
PERIPLUS_SIMD_FUNCTION(void, corners, (const GridCamera& c, int x, int y, int z, PlaneCorners& out), (c, x, y, z, out))
PERIPLUS_SIMD_FUNCTION(void, rectangles, (const GridCamera& c, int x, int y, int z, const PlaneCorners& lower, const PlaneCorners& upper, LayerRectangles& out),
                       (c, x, y, z, lower, upper, out))
PERIPLUS_SIMD_FUNCTION(std::uint64_t, seen, (const LayerRectangles& q, const float* squares, int width, int side, float margin), (q, squares, width, side, margin))

}  // namespace

bool measured_limits(const float* depth, const float* minimum, std::int32_t pixels, float* limit, std::uint8_t* measured, voxel::Simd simd) {
  return limits_for(simd)(depth, minimum, pixels, limit, measured);
}

void plane_corners(const GridCamera& camera, int x, int y0, int z0, PlaneCorners& out, voxel::Simd simd) { corners_for(simd)(camera, x, y0, z0, out); }

void layer_rectangles(const GridCamera& camera, int x, int y0, int z0, const PlaneCorners& lower, const PlaneCorners& upper, LayerRectangles& out,
                      voxel::Simd simd) {
  rectangles_for(simd)(camera, x, y0, z0, lower, upper, out);
}

std::uint64_t layer_seen_through(const LayerRectangles& rectangles, const float* squares, int width, int side, float margin, voxel::Simd simd) {
  return seen_for(simd)(rectangles, squares, width, side, margin);
}

void layer_pixels(const GridCamera& camera, int x, int y0, int z0, LayerPixels& out, voxel::Simd simd) { pixels_for(simd)(camera, x, y0, z0, out); }

}  // namespace periplus::object_model
