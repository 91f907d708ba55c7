#include "common/object_model/model_export.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "common/core/error.h"
#include "common/object_model/testing/exported_model.h"

namespace periplus::object_model {
namespace {

using namespace testing;

TEST(MeshExport, PlyHoldsTheSpheresSurface) {
  const Sphere sphere;
  const std::string ply = export_ply(model_of(sphere));
  std::size_t vertices = 0, faces = 0;
  std::istringstream header(ply);
  std::string line;
  while (std::getline(header, line) && line != "end_header") {
    std::sscanf(line.c_str(), "element vertex %zu", &vertices);
    std::sscanf(line.c_str(), "element face %zu", &faces);
  }
  const std::size_t start = static_cast<std::size_t>(header.tellg());
  ASSERT_GT(vertices, 300u);
  ASSERT_GT(faces, 500u);
  ASSERT_EQ(ply.size(), start + vertices * 15 + faces * 13);
  double error = 0;
  int red = 0;
  for (std::size_t i = 0; i < vertices; ++i) {
    float p[3];
    std::memcpy(p, &ply[start + i * 15], 12);
    error += std::abs((Eigen::Vector3d(p[0], p[1], p[2]) - sphere.center).norm() - sphere.radius);
    red += static_cast<unsigned char>(ply[start + i * 15 + 12]) > 150;
  }
  EXPECT_LT(error / static_cast<double>(vertices), 0.005);
  EXPECT_GT(red, static_cast<int>(vertices) / 2);
  for (std::size_t i = 0; i < faces; ++i) {
    const char* face = &ply[start + vertices * 15 + i * 13];
    ASSERT_EQ(face[0], 3);
    std::int32_t v[3];
    std::memcpy(v, face + 1, 12);
    for (std::int32_t n : v) ASSERT_LT(static_cast<std::size_t>(n), vertices);
  }
}

TEST(MeshExport, ObjHoldsTheMeshWithColoursAndNormals) {
  const ObjectModel model = model_of({});
  const SurfaceMesh mesh = extract_surface(model.grid(), model.state().tsdf, 0.06);
  std::istringstream in(to_obj(mesh));
  std::string line;
  std::size_t vertices = 0, normals = 0, faces = 0;
  while (std::getline(in, line)) {
    float a[6];
    unsigned i[6];
    if (std::sscanf(line.c_str(), "v %f %f %f %f %f %f", a, a + 1, a + 2, a + 3, a + 4, a + 5) == 6) {
      EXPECT_EQ(Eigen::Vector3f(a[0], a[1], a[2]), mesh.vertices[vertices]);
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(a[3 + c] * 255, mesh.colors[vertices][c], 1e-3);
      ++vertices;
    } else if (std::sscanf(line.c_str(), "vn %f %f %f", a, a + 1, a + 2) == 3) {
      EXPECT_NEAR(Eigen::Vector3f(a[0], a[1], a[2]).norm(), 1, 1e-5);
      ++normals;
    } else if (std::sscanf(line.c_str(), "f %u//%u %u//%u %u//%u", i, i + 1, i + 2, i + 3, i + 4, i + 5) == 6) {
      for (std::size_t n = 0; n < 3; ++n) {
        EXPECT_EQ(i[2 * n], mesh.triangles[faces][n] + 1);
        EXPECT_EQ(i[2 * n + 1], i[2 * n]);
      }
      ++faces;
    }
  }
  EXPECT_EQ(vertices, mesh.vertices.size());
  EXPECT_EQ(normals, mesh.vertices.size());
  EXPECT_EQ(faces, mesh.triangles.size());
}

TEST(MeshExport, NormalsOfAnOctahedronAreItsAxes) {
  SurfaceMesh mesh;
  for (int n = 0; n < 6; ++n) mesh.vertices.push_back(Eigen::Vector3f::Unit(n / 2) * (n % 2 ? -0.1f : 0.1f));
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  for (std::size_t n = 0; n < 6; ++n) EXPECT_TRUE(normals[n].isApprox(mesh.vertices[n] * 10, 1e-5f)) << normals[n].transpose();
}

TEST(MeshExport, NormalsPointOutOfTheSphere) {
  const Sphere sphere;
  const ObjectModel model = model_of(sphere, 0.5);
  const SurfaceMesh mesh = extract_surface(model.grid(), model.state().tsdf, 0.06);
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  double mean = 0;
  for (std::size_t i = 0; i < normals.size(); ++i)
    mean += normals[i].cast<double>().dot((mesh.vertices[i].cast<double>() - sphere.center).normalized()) / static_cast<double>(normals.size());
  EXPECT_GT(mean, 0.9);  // four views leave ragged rims between them
  const SurfacePoints cloud = surface_points(model);
  ASSERT_EQ(cloud.points.size(), model.grid().counts().known);
  double distance = 0, alike = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Eigen::Vector3d p = cloud.points[i].cast<double>();
    EXPECT_EQ(model.grid().state(model.grid().geometry().voxel_of(p)), voxel::VoxelState::known);
    distance += std::abs((p - sphere.center).norm() - sphere.radius) / static_cast<double>(cloud.points.size());
    alike += cloud.normals[i].cast<double>().dot((p - sphere.center).normalized()) / static_cast<double>(cloud.points.size());
  }
  EXPECT_LT(distance, 0.005);  // a quarter of a voxel, on the mean
  EXPECT_GT(alike, 0.9);
}

TEST(MeshExport, GlbIsAlignedAndTurnsTheWorldYUp) {
  const ObjectModel model = model_of({});
  const SurfaceMesh mesh = extract_surface(model.grid(), model.state().tsdf, 0.06);
  const std::string glb = to_glb(mesh);
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(number_at<std::uint32_t>(glb, 4), 2u);
  EXPECT_EQ(number_at<std::uint32_t>(glb, 8), glb.size());
  const std::size_t json = number_at<std::uint32_t>(glb, 12), binary = 20 + json;
  EXPECT_EQ(json % 4, 0u);
  EXPECT_EQ(glb.substr(binary + 4, 4), std::string("BIN\0", 4));
  ASSERT_EQ(binary + 8 + number_at<std::uint32_t>(glb, binary), glb.size());
  EXPECT_EQ(number_at<std::uint32_t>(glb, binary), 32 * mesh.vertices.size() + 12 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    EXPECT_EQ(number_at<float>(glb, binary + 8 + 12 * i + 4), mesh.vertices[i].z());
    EXPECT_EQ(number_at<float>(glb, binary + 8 + 12 * i + 8), -mesh.vertices[i].y());
  }
}

}  // namespace
}  // namespace periplus::object_model
