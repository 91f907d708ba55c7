#include "integration-tests/nbv_benchmark/surface_coverage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/random.h"
#include "integration-tests/nbv_benchmark/arena.h"
#include "integration-tests/nbv_benchmark/depth_scene.h"
#include "integration-tests/nbv_benchmark/subject.h"

namespace periplus::nbv_benchmark {
namespace {

// A sphere of radius r seen from distance d: the cap within the tangent cone, (1 - r / d) / 2 of its surface.
TEST(SurfaceCoverage, CapOfASphere) {
  const double r = 0.25, d = 1.0, near = 0.005;
  const mesh::TriangleMesh sphere = mesh::make_sphere(2 * r, 1);
  const mesh::TriangleTree tree(sphere);
  const auto samples = mesh::sample_surface(sphere, 40000, 1);
  DepthScene scene;
  scene.add(sphere, Pose::Identity());
  const Pinhole camera = single_camera();
  const Pose X = look_at({d, 0, 0}, {0, 0, 0});
  Mask covered(samples.size());
  add_covered(samples, scene.render(X, camera, 6), camera, X, near, covered);
  const double share = static_cast<double>(covered.count()) / static_cast<double>(samples.size());
  // The samples up to 5 mm beyond the outline count as well: at most 5 mm / r / 2 more. The sphere's flat facets hide a part of
  // themselves at the outline.
  const double cap = (1 - r / d) / 2, facets = 0.015;
  EXPECT_GT(share, cap - facets);
  EXPECT_LT(share, cap + near / r / 2);
  // From the other side: together what the two tangent cones leave open is missing.
  const Pose Y = look_at({-d, 0, 0}, {0, 0, 0});
  add_covered(samples, scene.render(Y, camera, 6), camera, Y, near, covered);
  const double two = static_cast<double>(covered.count()) / static_cast<double>(samples.size());
  EXPECT_GT(two, 2 * (cap - facets));
  EXPECT_LT(two, 2 * cap + near / r);

  // Visible at no more than 75 degrees from the normal: where cos(beta) = r / d would be grazing, beta + asin(...) is less.
  std::vector<Eigen::Vector3d> points, normals;
  for (const auto& s : samples) {
    points.push_back(s.point);
    normals.push_back(s.normal);
  }
  Mask visible(points.size());
  add_visible(points, normals, {&tree}, {camera, {X}}, visible);
  // Incidence i at polar angle b from the camera's axis: tan(i - b) (d - r cos b) = r sin b; solved for i = 75 degrees.
  const double i = 75 * M_PI / 180;
  double low = 0, high = M_PI / 2;
  for (int k = 0; k < 60; ++k) {
    const double b = (low + high) / 2;
    (b + std::atan2(r * std::sin(b), d - r * std::cos(b)) < i ? low : high) = b;
  }
  EXPECT_NEAR(static_cast<double>(visible.count()) / static_cast<double>(samples.size()), (1 - std::cos(low)) / 2, 0.01);
}

// The window of pixels misses nothing: every pixel against every sample gives the same.
TEST(SurfaceCoverage, SameAsAllPairs) {
  Random random(4);
  const Pinhole camera = Pinhole::from_vertical_fov(40, 30, 0.9);
  std::vector<mesh::SurfaceSample> samples(600);
  for (auto& s : samples) s.point = {random.uniform(-0.5, 0.5), random.uniform(-0.4, 0.4), random.uniform(0.7, 1.0)};
  ImageF depth(40, 30);
  for (float& z : depth.data) z = random.uniform() < 0.3 ? 0.0f : static_cast<float>(random.uniform(0.7, 1.0));
  for (const double distance : {0.01, 0.05, 0.2}) {
    Mask covered(samples.size()), expected(samples.size());
    add_covered(samples, depth, camera, Pose::Identity(), distance, covered);
    for (std::size_t i = 0; i < samples.size(); ++i)
      for (int v = 0; v < 30; ++v)
        for (int u = 0; u < 40; ++u)
          if (depth.at(u, v) > 0 && (camera.back_project(u, v, depth.at(u, v)) - samples[i].point).norm() <= distance) expected.set(i);
    EXPECT_EQ(covered, expected) << distance;
    EXPECT_GT(covered.count(), 0u);
  }
}

TEST(SurfaceCoverage, APairSeesWhatBothEyesSee) {
  // A wall with a post before it: what the post hides from either eye is not visible to the pair.
  mesh::TriangleMesh wall = mesh::make_box({0.02, 2, 2}, 1), post = mesh::make_box({0.02, 0.1, 2}, 1);
  mesh::transform(post, make_pose({0.5, 0, 0}, Eigen::Matrix3d::Identity()));
  const mesh::TriangleTree wall_tree(wall), post_tree(post);
  std::vector<Eigen::Vector3d> points, normals;
  for (int k = 0; k < 2000; ++k) {
    points.emplace_back(0.01, -0.6 + 1.2 * k / 2000, 0.0);
    normals.emplace_back(1, 0, 0);
  }
  const double b = 0.144;
  const Pose X = look_at({1.5, b / 2, 0}, {0, b / 2, 0});  // looks along -x: the right eye stands at -y... or +y
  const Pose Y = X * Pose(Eigen::Translation3d(b, 0, 0));
  Mask left(points.size()), right(points.size()), both(points.size());
  const Pinhole camera = single_camera();
  add_visible(points, normals, {&wall_tree, &post_tree}, {camera, {X}}, left);
  add_visible(points, normals, {&wall_tree, &post_tree}, {camera, {Y}}, right);
  add_visible(points, normals, {&wall_tree, &post_tree}, {camera, {X, Y}}, both);
  EXPECT_EQ(both.count(), left.in_common(right));
  EXPECT_LT(both.count(), left.count());
  EXPECT_GT(both.count(), 500u);
}

}  // namespace
}  // namespace periplus::nbv_benchmark
