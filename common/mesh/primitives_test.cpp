#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/mesh/triangle_mesh.h"

namespace periplus::mesh {
namespace {

TEST(Primitives, AreClosedFacingOutwardsAndOfTheRightSize) {
  constexpr double pi = std::numbers::pi;
  const auto box = make_box({0.7, 0.5, 1.3}, 1);
  EXPECT_NEAR(signed_volume(box), 0.7 * 0.5 * 1.3, 1e-12);
  EXPECT_NEAR(surface_area(box), 2 * (0.7 * 0.5 + 0.5 * 1.3 + 0.7 * 1.3), 1e-12);
  const auto cylinder = make_cylinder(0.4, 1.2, 1);
  EXPECT_NEAR(signed_volume(cylinder), pi * 0.04 * 1.2, 0.002 * pi * 0.04 * 1.2);
  EXPECT_NEAR(surface_area(cylinder), pi * 0.4 * 1.2 + 2 * pi * 0.04, 0.01);
  const auto sphere = make_sphere(1, 1);
  EXPECT_NEAR(signed_volume(sphere), pi / 6, 0.005);
  for (const auto* m : {&box, &cylinder, &sphere}) {
    m->check();
    EXPECT_EQ(m->corner_uv.size(), 3 * m->triangles.size());
    for (std::size_t i = 0; i < m->triangles.size(); ++i) {
      const auto& t = m->triangles[i];
      const auto corner = [&](int k) { return m->vertices[static_cast<std::size_t>(t[k])]; };
      const Eigen::Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
      EXPECT_GT(n.dot(m->corner_normals[3 * i]), 0.9);
    }
  }
  EXPECT_THROW(make_box({1, 0, 1}, 1), Error);
}

TEST(Primitives, TextureKeepsItsScale) {
  for (const auto& m : {make_box({0.7, 0.5, 1.3}, 2.0), make_cylinder(0.4, 1.2, 2.0)})
    for (std::size_t i = 0; i < m.triangles.size(); ++i) {
      const double length = (m.vertices[static_cast<std::size_t>(m.triangles[i][1])] - m.vertices[static_cast<std::size_t>(m.triangles[i][0])]).norm();
      EXPECT_NEAR((m.corner_uv[3 * i + 1] - m.corner_uv[3 * i]).norm(), 2 * length, 0.01 * length);
    }
}

}  // namespace
}  // namespace periplus::mesh
