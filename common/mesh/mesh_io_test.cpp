#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"
#include "common/mesh/triangle_mesh.h"

namespace periplus::mesh {
namespace {

class MeshFile : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    const std::string path = folder_ + "/" + name;
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string folder_ = std::filesystem::temp_directory_path() / ("mesh_io_test-" + std::to_string(getpid()));
};

TEST_F(MeshFile, PlyComesBack) {
  TriangleMesh box = make_box({0.2, 0.3, 0.4}, 1);
  box.colours.assign(box.vertices.size(), {1, 0.5, 0});
  const std::string path = folder_ + "/box.ply";
  write_ply(box, path);
  const TriangleMesh read = load(path);
  EXPECT_EQ(read.triangles.size(), box.triangles.size());
  EXPECT_LT(read.vertices.size(), box.vertices.size());  // equal positions became one vertex
  EXPECT_NEAR(signed_volume(read), 0.024, 1e-7);
  ASSERT_EQ(read.colours.size(), read.vertices.size());
  EXPECT_TRUE(read.colours[0].isApprox(Eigen::Vector3d(1, 0.5, 0), 0.01));
  EXPECT_THROW(write_ply(box, folder_ + "/nowhere/box.ply"), Error);
}

TEST_F(MeshFile, OffAndObj) {
  const TriangleMesh off = load(write("t.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"));
  EXPECT_EQ(off.triangles.size(), 4u);
  EXPECT_NEAR(signed_volume(off), 1.0 / 6, 1e-6);
  EXPECT_TRUE(off.corner_uv.empty());
  const TriangleMesh obj = load(write("q.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"));
  EXPECT_EQ(obj.triangles.size(), 2u);
  ASSERT_EQ(obj.corner_uv.size(), 6u);
  EXPECT_EQ(obj.corner_uv[1], Eigen::Vector2d(1, 0));
}

TEST_F(MeshFile, HostileFilesAreRefused) {
  const auto code_of = [](const std::string& path, const LoadLimits& limits = {}) {
    try {
      load(path, limits);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  };
  EXPECT_EQ(code_of(folder_ + "/absent.obj"), ErrorCode::io);
  EXPECT_EQ(code_of(write("text.off", "hello")), ErrorCode::bad_input);
  EXPECT_EQ(code_of(write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 77\n")), ErrorCode::bad_input);
  EXPECT_EQ(code_of(write("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")), ErrorCode::bad_input);
  EXPECT_EQ(code_of(write("points.obj", "v 0 0 0\nv 1 0 0\n")), ErrorCode::bad_input);
  const std::string good = write("good.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_EQ(code_of(good), ErrorCode::ok);
  EXPECT_EQ(code_of(good, {.most_bytes = 10, .most_triangles = 10}), ErrorCode::bad_size);
  EXPECT_EQ(code_of(good, {.most_bytes = 1000, .most_triangles = 0}), ErrorCode::bad_size);
}

TEST(Msh, HeaderAndCorners) {
  const TriangleMesh box = make_box({1, 1, 1}, 1);
  const std::string bytes = to_msh(box);
  std::int32_t head[4];
  std::memcpy(head, bytes.data(), sizeof(head));
  const auto corners = static_cast<std::int32_t>(3 * box.triangles.size());
  EXPECT_EQ(head[0], corners);
  EXPECT_EQ(head[1], corners);
  EXPECT_EQ(head[2], corners);
  EXPECT_EQ(head[3], corners / 3);
  EXPECT_EQ(bytes.size(), 16u + static_cast<std::size_t>(corners) * (3 + 3 + 2 + 1) * 4);
  float first[3];
  std::memcpy(first, bytes.data() + 16, sizeof(first));
  const Eigen::Vector3d p = box.vertices[static_cast<std::size_t>(box.triangles[0][0])];
  EXPECT_FLOAT_EQ(first[0], static_cast<float>(p.x()));
}

// Whatever byte the data begin with: a reader may take it for the end of the header's last line.
TEST(MeshIo, ReadsBinaryPlyThatBeginsWithAnyByte) {
  const std::string path = testing::TempDir() + "/mesh_io_first_byte.ply";
  for (int byte = 0; byte < 256; ++byte) {
    TriangleMesh m = make_box({1, 1, 1}, 1);
    m.corner_uv.clear();
    float x = -0.5f;
    std::memcpy(&x, &byte, 1);
    m.vertices[0].x() = x;
    write_ply(m, path);
    const TriangleMesh read = load(path);
    ASSERT_EQ(read.triangles.size(), m.triangles.size()) << byte;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(bounds(read).lower[c], bounds(m).lower[c], 1e-6) << byte;
    EXPECT_NEAR(surface_area(read), 6, 1e-4) << byte;
  }
}

}  // namespace
}  // namespace periplus::mesh
