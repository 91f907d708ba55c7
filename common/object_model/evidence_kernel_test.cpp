#include "common/object_model/evidence_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "common/core/random.h"
#include "common/object_model/evidence.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model {
namespace {

using namespace testing;

constexpr double kMargin = 0.87;

// The rays of one depth map in double precision, pixel by pixel, as evidence.h tells it.
struct Reference {
  std::map<std::size_t, std::array<int, 3>> counts;  // points, seen, solid

  void add(const DepthMap& map, const PixelLimits& limits, const voxel::GridGeometry& g) {
    const double h = g.voxel_size;
    const Pose X_GC = g.X_WG.inverse() * map.X_WC;
    const Eigen::Vector3d origin = X_GC.translation() / h;
    const Eigen::Array3d upper = g.size.cast<double>().array();
    const auto inside = [&](const Eigen::Vector3d& p) { return (p.array() >= 0).all() && (p.array() < upper).all(); };
    for (int y = 0; y < map.depth.height; ++y)
      for (int x = 0; x < map.depth.width; ++x) {
        const PixelKind kind = limits.kind.at(x, y);
        if (kind == PixelKind::none) continue;
        const double z = map.depth.at(x, y);
        const Eigen::Vector3d ray = X_GC.linear() * map.camera.back_project(x, y, 1) / h, point = origin + ray * z;
        if ((point.array() < -4).any() || (point.array() > upper + 4).any()) continue;
        if (kind == PixelKind::surface && inside(point)) ++counts[voxel_index(g, point.cast<int>())][0];
        const int radius = static_cast<int>(std::clamp(map.camera.fx * h / z, 1.0, static_cast<double>(map.depth.width)));
        double least = z;
        for (int dy = -radius; dy <= radius; dy += radius)
          for (int dx = -radius; dx <= radius; dx += radius) {
            const float m = map.depth_minimum.at(std::clamp(x + dx, 0, map.depth.width - 1), std::clamp(y + dy, 0, map.depth.height - 1));
            if (m > 0) least = std::min<double>(least, m);
          }
        least = std::max(std::min(least, z), z - 2.5 * h) - kMargin * h;
        std::size_t last = ~std::size_t{0};
        const double behind = std::min<double>(map.depth_sigma.at(x, y), 0.5 * h);
        for (int k = 0;; ++k) {
          const double t = z + (k == 0 ? behind : (0.3 - 0.5 * k) * h);
          if (t <= least) break;
          const Eigen::Vector3d p = origin + ray * t;
          if (!inside(p)) continue;
          const std::size_t i = voxel_index(g, p.cast<int>());
          if (i != last) ++counts[i][kind == PixelKind::surface ? 1 : 2];
          last = i;
        }
      }
  }
};

struct SphereAndKinds {
  Sphere sphere;
  voxel::GridGeometry g;
  DepthMap map;
  PixelLimits limits;

  explicit SphereAndKinds(int n) {
    const ObjectBox box = box_around(sphere);
    g = voxel::GridGeometry::from_box(box.X_WB * make_pose({0, 0, 0}, Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix()), box.size, 0.01);
    map = ideal_view(sphere, n, 6, 330, 240).depth[0];  // no multiple of a run
    limits.limit = map.depth;
    limits.kind = Image<PixelKind>(330, 240, 1, PixelKind::surface);
    Random random(static_cast<std::uint64_t>(n));
    for (std::size_t i = 0; i < limits.kind.data.size(); ++i) {
      const double kind = random.uniform();
      map.depth_sigma.data[i] = i % 3 == 0 ? 0.0f : static_cast<float>(random.uniform(0, 0.007));
      if (kind < 0.1) limits.kind.data[i] = PixelKind::none;
      if (kind > 0.8) limits.kind.data[i] = PixelKind::known_solid;
      if (kind > 0.4 && kind < 0.45) map.depth_minimum.data[i] = kind < 0.42 ? 0.0f : map.depth.data[i] - 0.02f;
    }
  }
};

// But for points within rounding of a voxel's border, which may count for either side.
TEST(EvidenceKernel, CountsWhatAPassInDoublePrecisionCounts) {
  for (const int n : {0, 1, 4}) {
    const SphereAndKinds s(n);
    Evidence evidence(s.g);
    add_points(s.map, s.limits, s.g, kMargin, evidence);
    Reference reference;
    reference.add(s.map, s.limits, s.g);
    long total[3] = {}, apart[3] = {};
    for_each_voxel(s.g, [&](const Eigen::Vector3i& v) {
      const auto at = reference.counts.find(voxel_index(s.g, v));
      const std::array<int, 3> expected = at == reference.counts.end() ? std::array<int, 3>{} : at->second;
      const VoxelEvidence e = evidence.at(v);
      const int found[3] = {e.points, e.seen, e.solid};
      for (std::size_t k = 0; k < 3; ++k) {
        total[k] += expected[k];
        apart[k] += std::abs(expected[k] - found[k]);
      }
    });
    for (const int k : {0, 1, 2}) {
      EXPECT_GT(total[k], 1000) << k;
      EXPECT_LT(apart[k], total[k] / 1000) << k << ": " << apart[k] << " of " << total[k];
    }
  }
}

TEST(EvidenceKernel, EveryInstructionSetGivesTheSameCounts) {
  for (const int n : {0, 3}) {
    const SphereAndKinds s(n);
    Evidence portable(s.g);
    add_points(s.map, s.limits, s.g, kMargin, portable, voxel::Simd::portable);
    for (const voxel::Simd simd : {voxel::Simd::avx2, voxel::Simd::avx512}) {
      if (!voxel::has_simd(simd)) continue;
      Evidence other(s.g);
      add_points(s.map, s.limits, s.g, kMargin, other, simd);
      EXPECT_TRUE(other == portable);
    }
  }
}

TEST(EvidenceKernel, CountersStopAtTheirLargestValue) {
  SphereAndKinds s(0);
  Evidence once(s.g), often(s.g);
  add_points(s.map, s.limits, s.g, kMargin, once);
  for (int n = 0; n < 3000; ++n) add_points(s.map, s.limits, s.g, kMargin, often);
  int full = 0;
  for_each_voxel(s.g, [&](const Eigen::Vector3i& v) {
    EXPECT_EQ(often.at(v).seen, std::min(65535, 3000 * once.at(v).seen));
    full += often.at(v).seen == 65535;
  });
  EXPECT_GT(full, 0);
}

}  // namespace
}  // namespace periplus::object_model
