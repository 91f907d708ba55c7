#include "services/nbv_planner/visible_list_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "common/core/random.h"

namespace periplus::nbv {
namespace {

using voxel::Simd;

struct Points {
  std::vector<float> x, y, z;
  std::vector<std::int32_t> weight;
  explicit Points(int n) {
    Random random(3);
    for (int i = 0; i < n; ++i) {
      x.push_back(static_cast<float>(random.uniform(-2, 2)));
      y.push_back(static_cast<float>(random.uniform(-2, 2)));
      z.push_back(static_cast<float>(random.uniform(-1, 1)));
      weight.push_back(static_cast<std::int32_t>(random.below(700)));
    }
  }
  PointArrays arrays() const { return {x.data(), y.data(), z.data(), weight.data(), static_cast<int>(x.size())}; }
};

WindowPlanes window() {
  WindowPlanes w;
  w.right[1] = -1;
  w.down[2] = -1;
  w.forward[0] = 1;
  w.tan_horizontal = 0.6f;
  w.tan_vertical = 0.4f;
  w.half_baseline = 0.07f;
  w.depth_min = 0.6f;
  w.depth_max = 1.9f;
  return w;
}

TEST(VisibleListKernel, CountsWhatIsInTheWindow) {
  const Points p(4096);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < p.x.size(); ++i) {
    const bool in = p.x[i] >= 0.6f && p.x[i] <= 1.9f && std::abs(p.y[i]) <= 0.6f * p.x[i] - 0.07f && std::abs(p.z[i]) <= 0.4f * p.x[i];
    sum += in ? p.weight[i] : 0;
  }
  EXPECT_GT(sum, 10000);
  EXPECT_EQ(window_sum(p.arrays(), window(), Simd::portable), sum);
}

TEST(VisibleListKernel, AnglesAreThoseOfTheLibrary) {
  const Points p(4096);
  std::vector<float> azimuth(p.x.size()), elevation(p.x.size());
  point_angles(p.arrays(), 1, azimuth.data(), elevation.data(), Simd::portable);
  for (std::size_t i = 0; i < p.x.size(); ++i) {
    EXPECT_NEAR(azimuth[i], std::atan2(p.y[i], p.x[i]) + std::numbers::pi, 1e-4);
    EXPECT_NEAR(elevation[i], std::atan2(p.z[i], std::hypot(p.x[i], p.y[i])), 1e-4);
  }
}

TEST(VisibleListKernel, VoxelsAreWhereTheirIndexSays) {
  VoxelPlacement q;
  q.size_y = 77;
  q.size_z = 511;
  for (int r = 0; r < 3; ++r) q.m[r][r] = 1;
  std::vector<std::uint32_t> index;
  Random random(4);
  for (int i = 0; i < 4000; ++i) index.push_back(static_cast<std::uint32_t>(random.below(512ull * 77 * 511)));
  for (std::uint32_t i = 0; i < 1100; ++i) index.push_back(i * 511);  // where divisions could round down
  std::vector<float> x(index.size()), y(index.size()), z(index.size());
  place_voxels(index.data(), static_cast<int>(index.size()), q, x.data(), y.data(), z.data(), Simd::portable);
  for (std::size_t i = 0; i < index.size(); ++i) {
    EXPECT_EQ(x[i], index[i] / 511 / 77);
    EXPECT_EQ(y[i], index[i] / 511 % 77);
    EXPECT_EQ(z[i], index[i] % 511);
  }
}

TEST(VisibleListKernel, EveryInstructionSetGivesTheSameBits) {
  const Points p(4096);
  WindowPlanes w = window();
  w.right[0] = 0.3f;
  w.forward[1] = -0.41f;
  VoxelPlacement q;
  q.size_y = 128;
  q.size_z = 100;
  Random random(5);
  for (auto& row : q.m)
    for (float& v : row) v = static_cast<float>(random.uniform(-0.1, 0.1));
  std::vector<std::uint32_t> index;
  for (int i = 0; i < 1000; ++i) index.push_back(static_cast<std::uint32_t>(random.below(128 * 128 * 100)));
  const auto all = [&](Simd simd) {
    std::vector<float> out(2 * p.x.size() + 3 * index.size());
    float* at = out.data();
    point_angles(p.arrays(), 14.3f, at, at + p.x.size(), simd);
    at += 2 * p.x.size();
    place_voxels(index.data(), static_cast<int>(index.size()), q, at, at + index.size(), at + 2 * index.size(), simd);
    return std::make_pair(out, window_sum(p.arrays(), w, simd));
  };
  const auto expected = all(Simd::portable);
  for (const Simd simd : {Simd::avx2, Simd::avx512, Simd::avx512_popcnt, Simd::best}) {
    if (!voxel::has_simd(simd)) continue;
    const auto found = all(simd);
    EXPECT_EQ(found.second, expected.second);
    EXPECT_EQ(std::memcmp(found.first.data(), expected.first.data(), found.first.size() * sizeof(float)), 0) << voxel::to_string(simd);
  }
}

}  // namespace
}  // namespace periplus::nbv
