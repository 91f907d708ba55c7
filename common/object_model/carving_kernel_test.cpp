#include "common/object_model/carving_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "common/core/random.h"

namespace periplus::object_model {
namespace {

GridCamera camera_at(double depth) {
  GridCamera c;
  c.width = 320;
  c.height = 240;
  const float h = 0.01f, f = 400;  // 1 cm voxels; the grid's z is the optical axis
  const float m[3][4] = {{f * h, 0, 160 * h, static_cast<float>(160 * depth)}, {0, f * h, 120 * h, static_cast<float>(120 * depth)}, {0, 0, h, static_cast<float>(depth)}};
  std::memcpy(c.m, m, sizeof m);
  return c;
}

// Voxel (0, y, z) from x = 0 on: its near face is the larger one.
void rectangles(const GridCamera& camera, int x, int y, int z, LayerRectangles& out, voxel::Simd simd) {
  PlaneCorners lower, upper;
  plane_corners(camera, x, y, z, lower, simd);
  plane_corners(camera, x + 1, y, z, upper, simd);
  layer_rectangles(camera, x, y, z, lower, upper, out, simd);
}

TEST(CarvingKernel, OnlyWhatIsMeasuredHasALimit) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  const std::vector<float> values{1, 2, 0, -1, inf, nan, 1.5f, 1e-30f};
  for (const voxel::Simd simd : {voxel::Simd::portable, voxel::Simd::avx2, voxel::Simd::avx512}) {
    if (!voxel::has_simd(simd)) continue;
    // Every pair, at any place in a vector and behind its end.
    for (int shift = 0; shift < 19; ++shift) {
      std::vector<float> depth(static_cast<std::size_t>(shift), 1.0f), least = depth;
      for (const float z : values) {
        for (const float m : values) {
          depth.push_back(z);
          least.push_back(m);
        }
      }
      std::vector<float> limit(depth.size());
      std::vector<std::uint8_t> measured(depth.size());
      EXPECT_FALSE(measured_limits(depth.data(), least.data(), static_cast<std::int32_t>(depth.size()), limit.data(), measured.data(), simd));
      EXPECT_TRUE(measured_limits(depth.data(), least.data(), shift, limit.data(), measured.data(), simd));
      for (std::size_t i = 0; i < depth.size(); ++i) {
        const bool is = std::isfinite(depth[i]) && depth[i] > 0 && least[i] > 0;
        EXPECT_EQ(measured[i], is ? 1 : 0) << depth[i] << " " << least[i];
        EXPECT_EQ(limit[i], is ? std::min(depth[i], least[i]) : 0.0f) << depth[i] << " " << least[i];
      }
    }
  }
}

TEST(CarvingKernel, RectanglesAreThoseOfTheClosedForm) {
  LayerRectangles r;
  rectangles(camera_at(1), 0, 0, 0, r, voxel::Simd::portable);
  for (int i = 0; i < kLayer; ++i) {
    const int y = i >> 3, z = i & 7;
    const double near = 1 + 0.01 * z, far = near + 0.01;
    EXPECT_EQ(r.inside[i], 1);
    EXPECT_NEAR(r.x0[i], 160, 0);
    EXPECT_NEAR(r.x1[i], std::floor(160 + 4 / near + 0.5), 1);
    EXPECT_NEAR(r.y0[i], std::floor(120 + 4 * y / far + 0.5), 1);
    EXPECT_NEAR(r.y1[i], std::floor(120 + 4 * (y + 1) / near + 0.5), 1);
    EXPECT_NEAR(r.depth[i], near + 0.005, 1e-4);
    EXPECT_GE(r.depth[i], near + 0.005 - 1e-7);
  }
  EXPECT_EQ(r.shortest, 4);
  rectangles(camera_at(-2), 0, 0, 0, r, voxel::Simd::portable);  // behind the camera
  EXPECT_EQ(r.shortest, 0);
}

TEST(CarvingKernel, EveryPixelOfTheRectangleMustLieBehind) {
  LayerRectangles r;
  rectangles(camera_at(1), 0, 0, 0, r, voxel::Simd::portable);
  for (const int side : {1, 2, 4}) {
    std::vector<float> squares(320 * 240, 2.0f);
    EXPECT_EQ(layer_seen_through(r, squares.data(), 320, side, 0.01f, voxel::Simd::portable), ~0ull);
    EXPECT_EQ(layer_seen_through(r, squares.data(), 320, side, 1.5f, voxel::Simd::portable), 0u);
  }
  // One near pixel takes those voxels whose rectangles hold it, at whatever corner.
  for (int pixel_y = 119; pixel_y < 156; ++pixel_y) {
    std::vector<float> squares(320 * 240, 2.0f);
    squares[static_cast<std::size_t>(pixel_y) * 320 + 163] = 0.5f;
    const std::uint64_t seen = layer_seen_through(r, squares.data(), 320, 1, 0.01f, voxel::Simd::portable);
    for (int i = 0; i < kLayer; ++i) {
      const bool holds = r.x0[i] <= 163 && 163 <= r.x1[i] && r.y0[i] <= pixel_y && pixel_y <= r.y1[i];
      EXPECT_EQ(seen >> i & 1, holds ? 0u : 1u);
    }
  }
}

TEST(CarvingKernel, EveryInstructionSetGivesTheSameBits) {
  Random random(12);
  std::vector<float> squares(320 * 240);
  for (float& v : squares) v = static_cast<float>(random.uniform(0.5, 3));
  for (int i = 0; i < 200; ++i) {
    GridCamera c = camera_at(random.uniform(-0.2, 2));
    for (auto& row : c.m) {
      for (float& v : row) v *= static_cast<float>(random.uniform(0.9, 1.1));
    }
    LayerRectangles expected, found;
    const int x = random.below(20), y = random.below(20), z = random.below(30);
    rectangles(c, x, y, z, expected, voxel::Simd::portable);
    for (const voxel::Simd simd : {voxel::Simd::avx2, voxel::Simd::avx512, voxel::Simd::avx512_popcnt}) {
      if (!voxel::has_simd(simd)) continue;
      rectangles(c, x, y, z, found, simd);
      EXPECT_EQ(std::memcmp(&found, &expected, sizeof found), 0);
      if (expected.shortest == 0) continue;
      EXPECT_EQ(layer_seen_through(expected, squares.data(), 320, 1, 0.01f, simd), layer_seen_through(expected, squares.data(), 320, 1, 0.01f, voxel::Simd::portable));
    }
  }
}

}  // namespace
}  // namespace periplus::object_model
