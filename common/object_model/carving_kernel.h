// Sixty-four voxels of a grid as an image shows them, once per instruction set. Plain data in, plain data out; no operation is fused or
// reordered, so that all give the same bits.
#pragma once

#include <cstdint>

#include "common/voxel/visibility.h"

namespace periplus::object_model {

// (u w, v w, w) of a point of the grid frame [voxels] is m (x, y, z, 1): u, v in pixels, pixel centres at integers; w in metres.
struct GridCamera {
  float m[3][4] = {};
  int width = 0, height = 0;
};

// Depth pixels that are measured, `depth` and `minimum` [m] both above 0 and `depth` finite: `limit` is the lesser of the two, else 0; `measured` 1 or 0.
// True if all are.
bool measured_limits(const float* depth, const float* minimum, std::int32_t pixels, float* limit, std::uint8_t* measured, voxel::Simd simd);

constexpr int kLayer = 64;  // voxels (x, y0 .. y0 + 7, z0 .. z0 + 7), z fastest
constexpr int kPlane = 72;  // corners (x, y0 .. y0 + 8, z0 .. z0 + 7), z fastest, each with the next along z

// What the voxels of two layers share: the corners between them.
struct PlaneCorners {
  float u0[kPlane], u1[kPlane], v0[kPlane], v1[kPlane];  // least and greatest of the two corners [px]
  float near[kPlane];                                    // least depth of the two [m]
};

void plane_corners(const GridCamera& camera, int x, int y0, int z0, PlaneCorners& out, voxel::Simd simd);

// Rectangles of pixels around the voxels' projections, both ends included, widened by what rounding may take.
struct LayerRectangles {
  std::int32_t x0[kLayer], y0[kLayer], x1[kLayer], y1[kLayer];
  float depth[kLayer];          // of the centre, rounded up [m]
  std::int32_t inside[kLayer];  // 1: wholly in front of the camera and within the image; else 0, and the rectangle is pixel (0, 0)
  std::int32_t shortest, longest_x, longest_y;  // sides over those inside [px]; shortest is 0 if none is
};

// `lower`, `upper`: the corners of planes x and x + 1.
void layer_rectangles(const GridCamera& camera, int x, int y0, int z0, const PlaneCorners& lower, const PlaneCorners& upper, LayerRectangles& out,
                      voxel::Simd simd);

// Bit i: voxel i is inside and every pixel of its rectangle is more than `margin` [m] behind its centre. `squares`: least values over squares
// of `side` pixels by upper left corner, rows of `width` (SquareMinimum); side <= rectangles.shortest.
std::uint64_t layer_seen_through(const LayerRectangles& rectangles, const float* squares, int width, int side, float margin, voxel::Simd simd);

// The pixels that the voxels' centres fall on.
struct LayerPixels {
  std::int32_t pixel[kLayer];  // row * width + column; -1 behind the camera or beside the image
  float depth[kLayer];         // of the centre [m]
};

void layer_pixels(const GridCamera& camera, int x, int y0, int z0, LayerPixels& out, voxel::Simd simd);

}  // namespace periplus::object_model
