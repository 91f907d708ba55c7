#include "common/mesh/made_models.h"

#include <gtest/gtest.h>

#include <map>

#include "common/core/error.h"
#include "common/mesh/part_builder.h"

namespace periplus::mesh {
namespace {

class MadeModel : public testing::TestWithParam<std::string> {};

// Each edge of a closed surface that faces outwards everywhere is run through once in each direction.
TEST_P(MadeModel, IsClosed) {
  const TriangleMesh m = make_model(GetParam());
  m.check();
  std::map<std::pair<int, int>, int> edges;
  for (const Eigen::Vector3i& t : m.triangles)
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, times] : edges) {
    ASSERT_EQ(times, 1);
    ASSERT_TRUE(edges.contains({edge.second, edge.first}));
  }
}

// Each part for itself: connected triangles.
TEST_P(MadeModel, EveryPartFacesOutwards) {
  const TriangleMesh m = make_model(GetParam());
  std::vector<int> root(m.vertices.size());
  for (std::size_t i = 0; i < root.size(); ++i) root[i] = static_cast<int>(i);
  const auto find = [&](int v) {
    while (root[static_cast<std::size_t>(v)] != v) v = root[static_cast<std::size_t>(v)] = root[static_cast<std::size_t>(root[static_cast<std::size_t>(v)])];
    return v;
  };
  for (const Eigen::Vector3i& t : m.triangles)
    for (int k = 1; k < 3; ++k) root[static_cast<std::size_t>(find(t[k]))] = find(t[0]);
  std::map<int, TriangleMesh> parts;
  for (const Eigen::Vector3i& t : m.triangles) {
    TriangleMesh& part = parts[find(t[0])];
    if (part.vertices.empty()) part.vertices = m.vertices;
    part.triangles.push_back(t);
  }
  EXPECT_GT(parts.size(), 10u);
  for (const auto& [first, part] : parts) EXPECT_GT(signed_volume(part), 0) << "near " << m.vertices[static_cast<std::size_t>(first)].transpose();
}

TEST_P(MadeModel, StandsOnTheFloorAndIsPainted) {
  const TriangleMesh m = make_model(GetParam());
  const Bounds b = bounds(m);
  EXPECT_NEAR(b.lower.z(), 0, 0.02);
  ASSERT_EQ(m.corner_uv.size(), 3 * m.triangles.size());
  const double height = GetParam() == "made:ship" ? 0.44 : GetParam() == "made:statue" ? 2.0 : 3.0;
  EXPECT_NEAR(b.size().z(), height, 0.03 * height);
  for (std::size_t i = 0; i < m.triangles.size(); ++i) {
    // The three corners lie in one band, and the picture is nowhere squeezed to less than a twentieth of its area.
    const int band = static_cast<int>(m.corner_uv[3 * i].y() * kMaterials);
    for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(static_cast<int>(m.corner_uv[3 * i + k].y() * kMaterials), band);
    const auto p = [&](int k) { return m.vertices[static_cast<std::size_t>(m.triangles[i][k])]; };
    const double area = (p(1) - p(0)).cross(p(2) - p(0)).norm() / 2;
    const Eigen::Vector2d u = m.corner_uv[3 * i + 1] - m.corner_uv[3 * i], v = m.corner_uv[3 * i + 2] - m.corner_uv[3 * i];
    const double picture = GetParam() == "made:ship" ? 1 : 2, painted = std::abs(u.x() * v.y() - u.y() * v.x()) / 2 * picture * picture;
    if (area > 1e-5) {
      EXPECT_GT(painted, 0.05 * area) << p(0).transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, MadeModel, testing::ValuesIn(made_models()), [](const auto& tested) { return tested.param.substr(5); });

TEST(MadeModels, AnUnknownNameSaysWhichThereAre) {
  try {
    make_model("made:zeppelin");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("made:ship"), std::string::npos);
  }
}

TEST(PartBuilder, TubesBoxesAndSheetsHaveTheirVolume) {
  PartBuilder tube(1), box(1), sheet(1);
  tube.tube({0, 0, 0}, {0, 0.3, 0.4}, 0.1, 0.1, 64, Material::bark);
  EXPECT_NEAR(signed_volume(tube.mesh()), 0.5 * 0.01 * 3.14159, 0.0001);
  box.box(make_pose({1, 2, 3}, rotation_from_yaw_pitch_roll(0.3, 0.2, 0.1)), {0.3, 0.2, 0.1}, 0.07, Material::stone);
  EXPECT_NEAR(signed_volume(box.mesh()), 0.006, 1e-12);
  std::vector<std::vector<Eigen::Vector3d>> flat;
  for (int i = 0; i < 4; ++i) flat.push_back({{i * 0.1, 0, 0}, {i * 0.1, 0.1, 0}, {i * 0.1, 0.2, 0}});
  sheet.sheet(flat, 0.01, Material::canvas);
  EXPECT_NEAR(signed_volume(sheet.mesh()), 0.3 * 0.2 * 0.01, 1e-12);
}

}  // namespace
}  // namespace periplus::mesh
