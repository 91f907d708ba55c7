// A layer's voxel centres through a GridCamera, for the kernels to inline.
#pragma once

#include <cstdint>

#include "common/object_model/carving_kernel.h"
#include "common/voxel/simd_function.h"

namespace periplus::object_model {

constexpr float kNearestDepth = 1e-3f;  // what is nearer to the camera's plane is not looked at [m]

struct LayerView {
  float a, b, w;  // what layer x adds to u w, v w and w
  float right, bottom;

  PERIPLUS_INLINE LayerView(const GridCamera& c, int x)
      : a(c.m[0][0] * (static_cast<float>(x) + 0.5f) + c.m[0][3]),
        b(c.m[1][0] * (static_cast<float>(x) + 0.5f) + c.m[1][3]),
        w(c.m[2][0] * (static_cast<float>(x) + 0.5f) + c.m[2][3]),
        right(static_cast<float>(c.width) - 0.5f),
        bottom(static_cast<float>(c.height) - 0.5f) {}

  // Pixel and depth [m] of voxel (x, y, z)'s centre; 1 where it is before the camera and within the image, else 0.
  PERIPLUS_INLINE std::int32_t center(const GridCamera& c, int y, int z, float& u, float& v, float& depth) const {
    const float fy = static_cast<float>(y) + 0.5f, fz = static_cast<float>(z) + 0.5f;
    depth = (w + c.m[2][1] * fy) + c.m[2][2] * fz;
    const float inverse = 1.0f / depth;
    u = ((a + c.m[0][1] * fy) + c.m[0][2] * fz) * inverse;
    v = ((b + c.m[1][1] * fy) + c.m[1][2] * fz) * inverse;
    return (depth > kNearestDepth) & (u > -0.5f) & (v > -0.5f) & (u < right) & (v < bottom);
  }
};

}  // namespace periplus::object_model
