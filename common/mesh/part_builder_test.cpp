#include "common/mesh/part_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "common/core/error.h"

namespace periplus::mesh {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

// Each edge is run through once in each direction: a closed surface, all of it facing the same way.
void expect_closed(const TriangleMesh& m) {
  m.check();
  std::map<std::pair<int, int>, int> edges;
  for (const Eigen::Vector3i& t : m.triangles)
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, times] : edges) {
    EXPECT_EQ(times, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first}));
  }
}

// Vertices less edges plus triangles of what is used: 2 of a ball, 0 of a ring.
int euler_characteristic(const TriangleMesh& m) {
  std::set<int> vertices;
  std::set<std::pair<int, int>> edges;
  for (const Eigen::Vector3i& t : m.triangles)
    for (int k = 0; k < 3; ++k) {
      vertices.insert(t[k]);
      edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
    }
  return static_cast<int>(vertices.size()) - static_cast<int>(edges.size()) + static_cast<int>(m.triangles.size());
}

std::vector<Vector3d> ring(double radius, double height, int sides) {
  std::vector<Vector3d> points;
  for (int k = 0; k < sides; ++k) points.emplace_back(radius * std::cos(2 * kPi * k / sides), radius * std::sin(2 * kPi * k / sides), height);
  return points;
}

// Of a regular polygon with unit circumradius.
double polygon_area(int sides) { return sides * std::sin(2 * kPi / sides) / 2; }

TEST(PartBuilder, ABoxHasItsVolumeAndAreaWhereverItStands) {
  const Pose X_MB = make_pose({0.3, -0.2, 1}, rotation_from_yaw_pitch_roll(0.7, 0.3, -0.5));
  PartBuilder b(2);
  b.box(X_MB, {0.7, 0.4, 0.25}, 0.1, Material::planks);
  const TriangleMesh& m = b.mesh();
  expect_closed(m);
  EXPECT_EQ(euler_characteristic(m), 2);
  EXPECT_NEAR(signed_volume(m), 0.7 * 0.4 * 0.25, 1e-12);
  EXPECT_NEAR(surface_area(m), 2 * (0.7 * 0.4 + 0.4 * 0.25 + 0.7 * 0.25), 1e-12);
  for (const Vector3d& p : m.vertices) EXPECT_LE(((X_MB.inverse() * p).cwiseAbs() - Vector3d(0.35, 0.2, 0.125)).maxCoeff(), 1e-12);
}

TEST(PartBuilder, ALoftIsThePrismOfItsRingsAndTheTubeACone) {
  PartBuilder prism(1);
  prism.loft({ring(0.2, 0, 6), ring(0.2, 0.3, 6), ring(0.2, 0.5, 6)}, Material::stone);
  expect_closed(prism.mesh());
  EXPECT_EQ(euler_characteristic(prism.mesh()), 2);
  EXPECT_NEAR(signed_volume(prism.mesh()), polygon_area(6) * 0.04 * 0.5, 1e-12);
  EXPECT_NEAR(surface_area(prism.mesh()), 6 * 0.2 * 0.5 + 2 * polygon_area(6) * 0.04, 1e-12);
  PartBuilder cone(1);
  cone.tube({0.1, 0.2, 0.3}, {0.5, -0.4, 1.1}, 0.2, 0.05, 9, Material::bark);
  expect_closed(cone.mesh());
  const double length = (Vector3d(0.5, -0.4, 1.1) - Vector3d(0.1, 0.2, 0.3)).norm();
  EXPECT_NEAR(signed_volume(cone.mesh()), polygon_area(9) * length / 3 * (0.04 + 0.2 * 0.05 + 0.0025), 1e-12);
}

TEST(PartBuilder, AJoinedTubeIsARing) {
  std::vector<Vector3d> line;
  for (int k = 0; k < 60; ++k) line.emplace_back(0.5 * std::cos(2 * kPi * k / 60), 0.5 * std::sin(2 * kPi * k / 60), 0.2);
  PartBuilder b(1);
  b.tube(line, std::vector<double>(60, 0.1), 24, Material::bronze, true);
  expect_closed(b.mesh());
  EXPECT_EQ(euler_characteristic(b.mesh()), 0);
  EXPECT_NEAR(signed_volume(b.mesh()), 2 * kPi * kPi * 0.5 * 0.01, 0.02 * 2 * kPi * kPi * 0.5 * 0.01);
}

TEST(PartBuilder, ASheetLiesBehindItsFront) {
  std::vector<std::vector<Vector3d>> front;  // rows along x, columns along y: its normal is +z
  for (int i = 0; i <= 4; ++i) {
    front.emplace_back();
    for (int j = 0; j <= 3; ++j) front.back().emplace_back(0.1 * i, 0.1 * j, 0.5);
  }
  PartBuilder b(1);
  b.sheet(front, 0.02, Material::canvas);
  expect_closed(b.mesh());
  EXPECT_EQ(euler_characteristic(b.mesh()), 2);
  EXPECT_NEAR(signed_volume(b.mesh()), 0.4 * 0.3 * 0.02, 1e-12);
  EXPECT_NEAR(surface_area(b.mesh()), 2 * 0.4 * 0.3 + 2 * (0.4 + 0.3) * 0.02, 1e-12);
  EXPECT_NEAR(bounds(b.mesh()).upper.z(), 0.5, 1e-12);
  EXPECT_NEAR(bounds(b.mesh()).lower.z(), 0.48, 1e-12);
}

TEST(PartBuilder, ALumpIsAnEllipsoidWithinItsBumps) {
  const Vector3d center(0.1, 0.2, 0.3), half(0.2, 0.3, 0.1);
  const auto lump = [&](double bumps, std::uint64_t seed) {
    PartBuilder b(1);
    b.lump(center, half, bumps, seed, Material::leaves);
    return b.mesh();
  };
  const TriangleMesh smooth = lump(0, 1);
  expect_closed(smooth);
  const double volume = 4 * kPi / 3 * half.prod();
  EXPECT_LT(signed_volume(smooth), volume);
  EXPECT_GT(signed_volume(smooth), 0.95 * volume);
  const TriangleMesh rough = lump(0.2, 1);
  expect_closed(rough);
  double least = 1, most = 1;
  for (const Vector3d& p : rough.vertices) {
    const double r = (p - center).cwiseQuotient(half).norm();
    if (r < 0.5) continue;  // the middles of the caps
    least = std::min(least, r);
    most = std::max(most, r);
  }
  EXPECT_GE(least, 0.8 - 1e-12);
  EXPECT_LE(most, 1.2 + 1e-12);
  EXPECT_GT(most - least, 0.05);
  EXPECT_EQ(lump(0.2, 1).vertices, rough.vertices);
  EXPECT_NE(lump(0.2, 2).vertices, rough.vertices);
}

// Pictures of a real scale, each part in the band of its material, the grain along the part.
TEST(PartBuilder, EachPartIsPaintedInTheBandOfItsMaterialAtOneScale) {
  constexpr double kPicture = 2;
  for (int material = 0; material < kMaterials; ++material) {
    PartBuilder b(kPicture);
    b.box(Pose::Identity(), {0.6, 0.2, 0.1}, 0.1, static_cast<Material>(material));
    const TriangleMesh& m = b.mesh();
    ASSERT_EQ(m.corner_uv.size(), 3 * m.triangles.size());
    int along = 0;
    for (std::size_t i = 0; i < m.triangles.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector2d uv = m.corner_uv[3 * i + k];
        EXPECT_GT(uv.y() * kMaterials, material + 0.02);
        EXPECT_LT(uv.y() * kMaterials, material + 0.98);
        const Vector3d way = m.vertices[static_cast<std::size_t>(m.triangles[i][static_cast<int>((k + 1) % 3)])] -
                             m.vertices[static_cast<std::size_t>(m.triangles[i][static_cast<int>(k)])];
        const Vector2d painted = m.corner_uv[3 * i + (k + 1) % 3] - uv;
        if (way.tail<2>().norm() < 1e-12) {  // an edge along x, on one of the four long sides
          EXPECT_NEAR(std::abs(painted.x()) * kPicture, way.norm(), 1e-12);
          EXPECT_NEAR(painted.y(), 0, 1e-12);
          ++along;
        }
      }
    }
    EXPECT_EQ(along, 2 * 6 * 6);  // twelve half-rings of edges: six columns of six pieces, an edge in two triangles
  }
}

TEST(PartBuilder, PartsAreAddedToOneAnother) {
  PartBuilder b(1);
  b.box(Pose::Identity(), {0.1, 0.1, 0.1}, 0.1, Material::paint);
  const std::size_t one = b.mesh().triangles.size();
  b.box(make_pose({1, 0, 0}, Eigen::Matrix3d::Identity()), {0.1, 0.1, 0.1}, 0.1, Material::stone);
  EXPECT_EQ(b.mesh().triangles.size(), 2 * one);
  expect_closed(b.mesh());
  EXPECT_NEAR(signed_volume(b.mesh()), 0.002, 1e-12);
}

TEST(PartBuilder, BadPartsAreRefused) {
  PartBuilder b(1);
  EXPECT_THROW(b.loft({ring(1, 0, 6)}, Material::stone), Error);
  EXPECT_THROW(b.loft({ring(1, 0, 2), ring(1, 1, 2)}, Material::stone), Error);
  EXPECT_THROW(b.loft({ring(1, 0, 6), ring(1, 1, 5)}, Material::stone), Error);
  EXPECT_THROW(b.loft({ring(1, 0, 6), ring(1, 1, 6)}, Material::stone, true), Error);
  EXPECT_THROW(b.tube({{0, 0, 0}, {0, 0, 1}}, {0.1}, 6, Material::stone), Error);
  EXPECT_THROW(b.sheet({{{0, 0, 0}, {0, 1, 0}}}, 0.1, Material::stone), Error);
}

}  // namespace
}  // namespace periplus::mesh
