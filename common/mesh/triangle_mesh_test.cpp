#include "common/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "common/core/error.h"

namespace periplus::mesh {
namespace {

using Eigen::Vector3d;

TEST(TriangleMesh, ChecksItsArrays) {
  TriangleMesh m = make_box({1, 1, 1}, 1);
  EXPECT_NO_THROW(m.check());
  TriangleMesh bad = m;
  bad.triangles[3][1] = static_cast<int>(m.vertices.size());
  EXPECT_THROW(bad.check(), Error);
  bad = m;
  bad.vertices[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(bad.check(), Error);
  bad = m;
  bad.corner_uv.pop_back();
  EXPECT_THROW(bad.check(), Error);
}

TEST(TriangleMesh, EveryUpAxisEndsUpright) {
  for (const char* axis : {"x", "y", "z", "-x", "-y", "-z"}) {
    TriangleMesh m = make_box({0.2, 0.3, 0.5}, 1);
    transform(m, make_pose({3, -2, 1}, Eigen::Matrix3d::Identity()));
    const TriangleMesh before = m;
    const double volume = signed_volume(m);
    const Placement placed = scale_upright(m, 1.0, axis);
    const Bounds b = bounds(m);
    EXPECT_NEAR(b.size().maxCoeff(), 1.0, 1e-12) << axis;
    EXPECT_NEAR(b.lower.z(), 0, 1e-12) << axis;
    EXPECT_NEAR((b.lower + b.upper).head<2>().norm(), 0, 1e-12) << axis;
    const int up = axis[axis[0] == '-' ? 1 : 0] - 'x';
    EXPECT_NEAR(b.size().z(), Vector3d(0.2, 0.3, 0.5)[up] * placed.scale, 1e-12) << axis;
    EXPECT_NEAR(placed.X.linear().determinant(), 1, 1e-12) << axis;
    EXPECT_NEAR(placed.X.linear()(2, up), axis[0] == '-' ? -1 : 1, 1e-12) << axis;
    EXPECT_NEAR(signed_volume(m), volume * std::pow(placed.scale, 3), 1e-12) << axis;
    for (std::size_t i = 0; i < m.vertices.size(); ++i)
      EXPECT_NEAR((placed.X * (placed.scale * before.vertices[i]) - m.vertices[i]).norm(), 0, 1e-12);
  }
  TriangleMesh m = make_box({1, 1, 1}, 1);
  EXPECT_THROW(scale_upright(m, 1, "w"), Error);
  EXPECT_THROW(scale_upright(m, -1, "z"), Error);
}

TEST(TriangleMesh, NormalsAreSmoothOnASphereAndSharpOnABox) {
  TriangleMesh sphere = make_sphere(2, 1);
  compute_normals(sphere);
  for (std::size_t i = 0; i < sphere.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const Vector3d p = sphere.vertices[static_cast<std::size_t>(sphere.triangles[i][k])];
      // The seam's vertices stand twice, so only half of their faces count.
      EXPECT_GT(sphere.corner_normals[3 * i + static_cast<std::size_t>(k)].dot(p), 0.99);
    }
  TriangleMesh box = make_box({1, 2, 3}, 1);
  compute_normals(box);
  for (const Vector3d& n : box.corner_normals) EXPECT_NEAR(n.cwiseAbs().maxCoeff(), 1, 1e-12);
}

TEST(TriangleMesh, TilesStayApart) {
  TriangleMesh m = make_sphere(0.4, 1);
  unwrap_six_tiles(m, 0.45);
  ASSERT_EQ(m.corner_uv.size(), 3 * m.triangles.size());
  for (std::size_t i = 0; i < m.triangles.size(); ++i) {
    Eigen::Vector2i tiles[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector2d uv = m.corner_uv[3 * i + k];
      EXPECT_TRUE(uv.minCoeff() >= 0 && uv.maxCoeff() <= 1);
      tiles[k] = {static_cast<int>(uv.x() * 3), static_cast<int>(uv.y() * 2)};
    }
    EXPECT_TRUE(tiles[0] == tiles[1] && tiles[1] == tiles[2]);
  }
}

TEST(TriangleMesh, SamplesAreUniformByArea) {
  const TriangleMesh m = make_box({1, 2, 3}, 1);
  const auto samples = sample_surface(m, 20000, 5);
  const auto again = sample_surface(m, 20000, 5);
  int on_top = 0;
  Vector3d mean = Vector3d::Zero();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].point, again[i].point);
    on_top += samples[i].normal.z() > 0.5;
    mean += samples[i].point / 20000;
  }
  EXPECT_NEAR(on_top / 20000.0, 2.0 / 22.0, 0.008);  // three standard deviations: 0.006
  EXPECT_LT(mean.norm(), 0.03);
  EXPECT_NE(sample_surface(m, 1, 6)[0].point, samples[0].point);
}

TEST(TriangleMesh, FlipTurnsVolume) {
  TriangleMesh m = make_box({1, 2, 3}, 1);
  EXPECT_NEAR(signed_volume(m), 6, 1e-12);
  flip(m);
  EXPECT_NEAR(signed_volume(m), -6, 1e-12);
}

}  // namespace
}  // namespace periplus::mesh
