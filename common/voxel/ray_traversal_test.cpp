#include "common/voxel/ray_traversal.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "common/core/random.h"

namespace periplus::voxel {
namespace {

using Voxel = std::array<int, 3>;

GridGeometry grid_of(int x, int y, int z) {
  GridGeometry g;
  g.voxel_size = 0.02;
  g.size = {x, y, z};
  return g;
}

std::vector<Voxel> along(const GridGeometry& g, const Eigen::Vector3d& o, const Eigen::Vector3d& d, double range = 10) {
  std::vector<Voxel> voxels;
  traverse_ray(g, o, d, range, [&](const Eigen::Vector3i& v, double, double) {
    voxels.push_back({v.x(), v.y(), v.z()});
    return true;
  });
  return voxels;
}

TEST(RayTraversal, AlongAnAxis) {
  const GridGeometry g = grid_of(4, 3, 3);
  const std::vector<Voxel> forth{{0, 1, 2}, {1, 1, 2}, {2, 1, 2}, {3, 1, 2}};
  EXPECT_EQ(along(g, {-1, 0.03, 0.05}, {1, 0, 0}), forth);
  EXPECT_EQ(along(g, {1, 0.03, 0.05}, {-1, 0, 0}), std::vector<Voxel>(forth.rbegin(), forth.rend()));
  EXPECT_EQ(along(g, {0.03, 0.03, 0.05}, {1, 0, 0}), std::vector<Voxel>(forth.begin() + 1, forth.end()));  // begins inside
  EXPECT_EQ(along(g, {-1, 0.03, 0.05}, {1, 0, 0}, 1.03).size(), 2u);                                       // ends inside
  EXPECT_TRUE(along(g, {-1, 0.07, 0.05}, {1, 0, 0}).empty());
  EXPECT_TRUE(along(g, {1, 0.03, 0.05}, {1, 0, 0}).empty());  // behind
  int seen = 0;
  EXPECT_FALSE(traverse_ray(g, {-1, 0.03, 0.05}, {1, 0, 0}, 10, [&](const auto&, double, double) { return ++seen < 2; }));
  EXPECT_EQ(seen, 2);
}

// Against small steps along the ray: the same voxels in the same order, but for those that it cuts by less than a step.
TEST(RayTraversal, AgreesWithSmallSteps) {
  const GridGeometry g = grid_of(11, 7, 9);
  const Eigen::Vector3d size = g.size.cast<double>() * g.voxel_size;
  Random random(5);
  int rays = 0, inside = 0;
  for (int i = 0; i < 400; ++i) {
    Eigen::Vector3d o, to;
    for (int a = 0; a < 3; ++a) {
      o[a] = random.uniform(-0.15, size[a] + 0.15);
      to[a] = random.uniform(0, size[a]);
    }
    const Eigen::Vector3d d = (to - o).normalized();
    std::vector<Voxel> stepped;
    constexpr double kStep = 2e-5;
    for (double t = kStep / 2; t < 1.5; t += kStep) {
      const Eigen::Vector3d p = (o + t * d) / g.voxel_size;
      const Voxel v{static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())), static_cast<int>(std::floor(p.z()))};
      if (g.contains({v[0], v[1], v[2]}) && (stepped.empty() || stepped.back() != v)) stepped.push_back(v);
    }
    std::vector<Voxel> long_enough;
    double last = 0;
    traverse_ray(g, o, d, 1.5, [&](const Eigen::Vector3i& v, double entry, double exit) {
      EXPECT_TRUE(g.contains(v));
      EXPECT_GE(entry, 0);
      EXPECT_GT(exit, entry);
      EXPECT_NEAR(entry, last > 0 ? last : entry, 1e-12);  // no gap between neighbours
      last = exit;
      // The middle of the stretch lies in the voxel.
      const Eigen::Vector3d middle = (o + (entry + exit) / 2 * d) / g.voxel_size - v.cast<double>();
      EXPECT_TRUE((middle.array() > -1e-9).all() && (middle.array() < 1 + 1e-9).all());
      if (exit - entry > 1.01 * kStep) long_enough.push_back({v.x(), v.y(), v.z()});
      return true;
    });
    std::size_t k = 0;
    for (const Voxel& v : stepped) k += k < long_enough.size() && long_enough[k] == v;
    EXPECT_EQ(k, long_enough.size()) << "ray " << i;
    rays += !stepped.empty();
    inside += g.contains(g.voxel_of(o));
  }
  EXPECT_GT(rays, 390);
  EXPECT_GT(inside, 5);
}

}  // namespace
}  // namespace periplus::voxel
