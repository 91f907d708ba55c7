#include "common/object_model/log_odds_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "common/core/random.h"
#include "common/object_model/grid_projection.h"

namespace periplus::object_model {
namespace {

// Random depths in blocks of 6 x 6 pixels, so that nine places within rounding of a pixel's border mostly read the same.
struct BlockyDepths {
  Pinhole pinhole = Pinhole::from_vertical_fov(240, 180, 0.5);
  voxel::GridGeometry g = voxel::GridGeometry::from_box(Pose::Identity(), {0.32, 0.32, 0.32}, 0.01);
  Pose X_WC = look_at({-0.9, 0.2, 0.3}, {0, 0, 0});
  std::vector<float> surface, free;
  DepthEvidence says;

  explicit BlockyDepths(std::uint64_t seed) : surface(240 * 180), free(240 * 180) {
    Random random(seed);
    for (int by = 0; by < 30; ++by)
      for (int bx = 0; bx < 40; ++bx) {
        const double kind = random.uniform();
        const auto z = static_cast<float>(random.uniform(0.7, 1.3));
        for (int y = 6 * by; y < 6 * by + 6; ++y)
          for (int x = 6 * bx; x < 6 * bx + 6; ++x) {
            const auto at = static_cast<std::size_t>(240 * y + x);
            free[at] = kind < 0.2 ? 0.0f : z;
            surface[at] = kind < 0.4 ? 0.0f : z;
          }
      }
    says.surface = surface.data();
    says.free = free.data();
    says.focal_px = static_cast<float>(pinhole.fx);
    says.voxel_m = 0.01f;
    says.margin_m = 0.0087f;
    says.sigma_per_z2 = 0.004f;
    says.pose_variance = 1e-6f;
    says.hit = 0.85f;
    says.miss = -0.4f;
  }

  // log_odds.h in double precision. Nothing where a place lies within rounding of a pixel's border.
  bool reference(const Eigen::Vector3i& v, double& out) const {
    const Eigen::Vector3d c = X_WC.inverse() * g.center_world(v);
    const Eigen::Vector2d q = pinhole.project(c);
    out = 0;
    if (c.z() <= 1e-3 || q.x() <= -0.5 || q.y() <= -0.5 || q.x() >= 239.5 || q.y() >= 179.5) return true;
    const double step = std::min(16.0, pinhole.fx * 0.01 / (3 * c.z()));
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const double u = q.x() + dx * step + 0.5, w = q.y() + dy * step + 0.5;
        if (std::abs(u - std::round(u)) < 1e-3 || std::abs(w - std::round(w)) < 1e-3) return false;
        const int column = std::clamp(static_cast<int>(u), 0, 239), row = std::clamp(static_cast<int>(w), 0, 179);
        const auto at = static_cast<std::size_t>(240 * row + column);
        const double sigma_z = 0.004 * free[at] * free[at], fade = 2 * std::sqrt(sigma_z * sigma_z + 1e-6) + 1e-5;
        if (free[at] > 0) out -= 0.4 * std::clamp((free[at] - c.z() - 0.0087) / fade, 0.0, 1.0) / 9;
        if (surface[at] > 0) out += 0.85 * (1 - std::clamp((std::abs(surface[at] - c.z()) - 0.0087) / fade, 0.0, 1.0)) / 9;
      }
    return true;
  }
};

TEST(LogOddsKernel, GivesWhatTheFormulaGivesInDoublePrecision) {
  const BlockyDepths s(1);
  const GridProjection projection(s.pinhole, s.X_WC, s.g);
  int compared = 0, hit = 0, missed = 0;
  float out[kLayer];
  for (int x = 0; x < 32; ++x)
    for (int y = 0; y < 32; y += 8)
      for (int z = 0; z < 32; z += 8) {
        layer_log_odds(projection.camera, s.says, x, y, z, out, voxel::Simd::best);
        for (int i = 0; i < kLayer; ++i) {
          double expected;
          if (!s.reference({x, y + (i >> 3), z + (i & 7)}, expected)) continue;
          ++compared;
          hit += expected > 0.1;
          missed += expected < -0.1;
          ASSERT_NEAR(out[i], expected, 1e-3) << x << ' ' << y << ' ' << z << ' ' << i;
        }
      }
  EXPECT_GT(compared, 25000);
  EXPECT_GT(hit, 1000);
  EXPECT_GT(missed, 1000);
}

TEST(LogOddsKernel, EveryInstructionSetGivesTheSameBits) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    BlockyDepths s(seed);
    s.X_WC = look_at({-0.9 + 0.05 * static_cast<double>(seed), 0.2, 0.3}, {0, 0, 0});  // ends within the grid
    const GridProjection projection(s.pinhole, s.X_WC, s.g);
    float expected[kLayer], found[kLayer];
    for (int x = 0; x < 32; x += 5) {
      layer_log_odds(projection.camera, s.says, x, 8, 16, expected, voxel::Simd::portable);
      for (const voxel::Simd simd : {voxel::Simd::avx2, voxel::Simd::avx512, voxel::Simd::avx512_popcnt}) {
        if (!voxel::has_simd(simd)) continue;
        layer_log_odds(projection.camera, s.says, x, 8, 16, found, simd);
        EXPECT_EQ(std::memcmp(found, expected, sizeof found), 0);
      }
    }
  }
}

}  // namespace
}  // namespace periplus::object_model
