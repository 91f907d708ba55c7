#include "common/object_model/model_export.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cstring>
#include <sstream>

#include "common/core/error.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model {
namespace {

using namespace testing;

ObjectModel model_of(const Sphere& sphere, double yaw = 0) {
  ObjectBox box = box_around(sphere);
  box.X_WB.linear() = rotation_from_yaw_pitch_roll(yaw, 0, 0);
  ObjectModel model("ball", box, 0.02, {});
  for (int n = 0; n < 4; ++n) model.integrate(ideal_view(sphere, n, 4), {}, {});
  return model;
}

TEST(ModelExport, PlyHoldsTheSpheresSurface) {
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

TEST(ModelExport, OctoMapReadsTheTreeAsTheGridIs) {
  for (const double yaw : {0.0, 0.5}) {
    const ObjectModel model = model_of({}, yaw);
    std::istringstream in(export_bt(model));
    octomap::OcTree tree(0.1);
    ASSERT_TRUE(tree.readBinary(in));
    EXPECT_DOUBLE_EQ(tree.getResolution(), 0.02);
    // Leaves are asked at their own centres.
    int occupied = 0, empty = 0, unknown = 0;
    for (int x = -20; x < 20; ++x)
      for (int y = -20; y < 20; ++y)
        for (int z = 30; z < 70; ++z) {
          const Eigen::Vector3d p = (Eigen::Vector3d(x, y, z).array() + 0.5) * 0.02;
          const Eigen::Vector3i v = model.grid().geometry().voxel_of(p);
          const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
          if (!model.grid().geometry().contains(v) || model.grid().state(v) == voxel::VoxelState::unknown) {
            EXPECT_EQ(node, nullptr);
            ++unknown;
          } else {
            ASSERT_NE(node, nullptr);
            EXPECT_EQ(tree.isNodeOccupied(node), model.grid().state(v) != voxel::VoxelState::empty);
            ++(tree.isNodeOccupied(node) ? occupied : empty);
          }
        }
    EXPECT_GT(occupied, 200);
    EXPECT_GT(empty, 1000);
    EXPECT_GT(unknown, 100);
  }
}

TEST(ModelExport, RefusesWhatOctoMapCannotAddress) {
  ObjectBox box;
  box.X_WB.translation() = Eigen::Vector3d(500, 0, 0);
  box.size = {0.1, 0.1, 0.1};
  EXPECT_THROW(export_bt(ObjectModel("far", box, 0.01, {})), Error);
}

}  // namespace
}  // namespace periplus::object_model
