#include "common/object_model/surface.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "common/object_model/evidence.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model {
namespace {

using namespace testing;

// Exact signed distances of a sphere.
Tsdf sphere_field(const voxel::GridGeometry& g, const Sphere& sphere) {
  Tsdf tsdf(g);
  for_each_voxel(g, [&](const Eigen::Vector3i& v) {
    TsdfSample s;
    s.distance = static_cast<float>(std::clamp((g.center_world(v) - sphere.center).norm() - sphere.radius, -0.03, 0.03));
    s.weight = 1;
    s.r = 250;
    s.color_weight = 1;
    tsdf.set(v, s);
  });
  return tsdf;
}

voxel::OccupancyGrid known_where(const voxel::GridGeometry& g, auto&& predicate) {
  voxel::OccupancyGrid grid(g);
  for_each_voxel(g, [&](const Eigen::Vector3i& v) { grid.set_state(v, predicate(v) ? voxel::VoxelState::known : voxel::VoxelState::empty); });
  return grid;
}

TEST(Surface, OfASphereIsClosedOutwardAndInPlace) {
  const Sphere sphere;
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(box_around(sphere).X_WB, {0.4, 0.4, 0.4}, 0.01);
  const SurfaceMesh mesh = extract_surface(known_where(g, [&](const Eigen::Vector3i& v) { return touches(g, v, sphere); }), sphere_field(g, sphere), 0.03);
  ASSERT_GT(mesh.triangles.size(), 1000u);
  ASSERT_EQ(mesh.vertices.size(), mesh.colors.size());
  for (const auto& v : mesh.vertices) EXPECT_NEAR((v.cast<double>() - sphere.center).norm(), sphere.radius, 0.001);
  EXPECT_EQ(mesh.colors[0][0], 250);
  double volume = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    const auto p = [&](int n) { return Eigen::Vector3d(mesh.vertices[t[static_cast<std::size_t>(n)]].cast<double>() - sphere.center); };
    volume += p(0).dot(p(1).cross(p(2))) / 6;
    for (std::size_t n = 0; n < 3; ++n) ++edges[{t[n], t[(n + 1) % 3]}];
  }
  EXPECT_NEAR(volume, 4.0 / 3 * std::numbers::pi * std::pow(sphere.radius, 3), 0.02 * volume);
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
  }
}

TEST(Surface, StandsOnlyNextToKnownVoxels) {
  const Sphere sphere;
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(box_around(sphere).X_WB, {0.4, 0.4, 0.4}, 0.01);
  const SurfaceMesh half = extract_surface(
      known_where(g, [&](const Eigen::Vector3i& v) { return touches(g, v, sphere) && g.center_world(v).x() > 0; }), sphere_field(g, sphere), 0.03);
  ASSERT_FALSE(half.vertices.empty());
  for (const auto& v : half.vertices) EXPECT_GT(v.x(), -0.015f);
  EXPECT_TRUE(extract_surface(voxel::OccupancyGrid(g), sphere_field(g, sphere), 0.03).triangles.empty());
}

TEST(Surface, SkipsJumpsFromOneSurfaceToAnother) {
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, 0.01);
  Tsdf tsdf(g);
  for_each_voxel(g, [&](const Eigen::Vector3i& v) { tsdf.set(v, {v.x() < 5 ? 0.03f : -0.03f, 1, 0, 0, 0, 0}); });
  EXPECT_TRUE(extract_surface(known_where(g, [](const Eigen::Vector3i&) { return true; }), tsdf, 0.03).triangles.empty());
}

}  // namespace
}  // namespace periplus::object_model
