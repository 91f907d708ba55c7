#include "integration-tests/nbv_benchmark/depth_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/mesh/triangle_tree.h"

namespace periplus::nbv_benchmark {
namespace {

Pinhole small_camera() { return Pinhole::from_vertical_fov(160, 120, 0.8); }

// Triangles of all sizes and orientations, some behind the camera, some through its plane.
mesh::TriangleMesh soup(int count, std::uint64_t seed) {
  Random random(seed);
  mesh::TriangleMesh m;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d middle(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const double size = std::pow(10, random.uniform(-2.5, 0.3));
    for (int c = 0; c < 3; ++c) m.vertices.push_back(middle + size * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
    m.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return m;
}

TEST(DepthScene, AgreesWithRaysAtEveryPixel) {
  const mesh::TriangleMesh m = soup(300, 3);
  const mesh::TriangleTree tree(m);
  DepthScene scene;
  scene.add(m, Pose::Identity());
  const Pinhole camera = small_camera();
  Random random(5);
  int hits = 0, different = 0;
  for (int k = 0; k < 6; ++k) {
    // The last ones stand amid the triangles.
    const double r = k < 4 ? 2.5 : 0.3;
    const Pose X_WC = look_at({r * std::cos(k), r * std::sin(k), random.uniform(-1, 1)}, {0.1, 0, 0});
    const ImageF depth = scene.render(X_WC, camera, 9);
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u) {
        // t counts in depths, as the direction's component along the axis is 1.
        const auto hit = tree.ray(X_WC.translation(), X_WC.linear() * camera.back_project(u, v, 1));
        hits += hit.has_value();
        const double expected = hit ? hit->t : 9;
        different += std::abs(depth.at(u, v) - expected) > 1e-5 * (1 + expected);
      }
  }
  EXPECT_GT(hits, 20000);
  // Rays through an edge may fall to either side.
  EXPECT_LE(different, 3);
}

TEST(DepthScene, SphereInClosedFormAndWatertight) {
  const double radius = 0.25;
  const mesh::TriangleMesh sphere = mesh::make_sphere(2 * radius, 1);
  DepthScene scene;
  scene.add(sphere, make_pose({1, 2, 3}, Eigen::Matrix3d::Identity()));
  const Pinhole camera = small_camera();
  const Pose X_WC = look_at({2, 2.2, 3.4}, {1, 2, 3});
  const ImageF depth = scene.render(X_WC, camera, 0);
  const Eigen::Vector3d c = X_WC.inverse() * Eigen::Vector3d(1, 2, 3);
  int inside = 0;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d d = camera.back_project(u, v, 1);
      const double a = d.squaredNorm(), b = d.dot(c), q = b * b - a * (c.squaredNorm() - radius * radius);
      if (q < 0.02 * a) continue;  // within the facets' error of the outline
      ++inside;
      ASSERT_NEAR(depth.at(u, v), (b - std::sqrt(q)) / a, 0.01 * radius) << u << " " << v;
    }
  EXPECT_GT(inside, 1000);
}

TEST(DepthScene, RefusesWhatCannotBe) {
  const DepthScene nothing;
  const ImageF depth = nothing.render(Pose::Identity(), small_camera(), 7);
  EXPECT_EQ(depth.at(3, 4), 7);
  Pose X = Pose::Identity();
  X.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(nothing.render(X, small_camera(), 7), Error);
  EXPECT_THROW(nothing.render(Pose::Identity(), Pinhole{}, 7), Error);
}

}  // namespace
}  // namespace periplus::nbv_benchmark
