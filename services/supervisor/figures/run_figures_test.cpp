#include "services/supervisor/figures/run_figures.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "common/core/error.h"
#include "common/core/file.h"

namespace periplus::supervisor {
namespace {

std::string npy(const std::string& data) {
  const std::string dict = "{'descr': '|u1', 'fortran_order': False, 'shape': (), }";
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(dict.size()) + '\0' + dict + data;
}

// 20 voxels of 5 cm a side about (0, 0, 0.5): a known block in the lower half, and an unknown one upon it.
void write_grid(const std::string& folder) {
  std::filesystem::create_directories(folder);
  std::string states;
  for (int x = 0; x < 20; ++x)
    for (int y = 0; y < 20; ++y)
      for (int z = 0; z < 20; ++z) {
        const bool inside = x >= 5 && x < 15 && y >= 5 && y < 15;
        states += static_cast<char>(inside && z < 10 ? 2 : inside && z < 12 ? 1 : 0);
      }
  std::ofstream(folder + "/grid.npy", std::ios::binary) << npy(states);
  std::ofstream(folder + "/grid.json") << R"({"voxel_m": 0.05, "size": [20, 20, 20], "pose_world_grid": [[1,0,0,-0.5],[0,1,0,-0.5],[0,0,1,0],[0,0,0,1]]})";
}

TEST(RunFigures, FacesOfAStateBorderOnEmptySpace) {
  const std::string folder = testing::TempDir() + "/run_figures_grid";
  write_grid(folder);
  const RecordedGrid grid = read_recorded_grid(folder);
  EXPECT_EQ(grid.at({5, 5, 0}), 2);
  EXPECT_EQ(grid.at({5, 5, 10}), 1);
  EXPECT_EQ(grid.at({0, 0, 0}), 0);
  EXPECT_FALSE(grid.at({20, 0, 0}));
  const mesh::TriangleMesh unknown = exposed_faces(grid, 1, {0, 1, 0});
  unknown.check();
  // Top and four sides, two voxels high; not the side that lies on the known block.
  EXPECT_EQ(unknown.triangles.size(), 2u * (100 + 4 * 20));
  EXPECT_NEAR(mesh::surface_area(unknown), 0.5 * 0.5 + 4 * 0.5 * 0.1, 1e-9);
  EXPECT_NEAR(mesh::bounds(unknown).lower.z(), 0.5, 1e-9);
  EXPECT_EQ(exposed_faces(only_near_known(grid, 1), 1, {0, 1, 0}).triangles.size(), 2u * (100 + 4 * 10));
  // All faces turn outwards: with its floor the block would be closed.
  EXPECT_GT(mesh::signed_volume(unknown), 0);
}

TEST(RunFigures, ShowTheRobotAtEachLookAndTheUnknownInGreen) {
  const std::string run = testing::TempDir() + "/run_figures", source = PERIPLUS_SOURCE_DIR;
  std::filesystem::remove_all(run);
  std::filesystem::create_directories(run);
  for (const char* file : {"/robot.urdf", "/robot.yaml"})
    std::filesystem::copy_file(source + "/deploy/robots/hrp2like" + std::string(file).substr(6), run + file);
  std::ofstream(run + "/scene.yaml") << "name: test\nroom: {size_m: [6, 6, 3]}\nsolids:\n  - {name: box, size_m: [0.4, 0.4, 1.0], position_m: [0, 1.6, 0.5]}\n";
  write_grid(run + "/looks/01");
  write_grid(run + "/looks/02");
  mesh::TriangleMesh block = mesh::make_box({0.5, 0.5, 0.5}, 1);
  mesh::transform(block, make_pose({0, 0, 0.25}, Eigen::Matrix3d::Identity()));
  mesh::write_ply(block, run + "/model.ply");
  std::ofstream(run + "/report.json") << R"({"task": "test", "looks": [
    {"look": 1, "coverage": 0.5, "pose_world_camera": [[0,0,1,-1.5],[-1,0,0,0],[0,-1,0,1.3],[0,0,0,1]]},
    {"look": 2, "coverage": 0.75, "pose_world_camera": [[0,0,-1,1.5],[1,0,0,0],[0,-1,0,1.3],[0,0,0,1]]}]})";
  const std::vector<std::string> paths = write_figures(run, run + "/figures", {.azimuth_deg = -90.0, .width = 500, .height = 400});
  ASSERT_EQ(paths.size(), 3u);
  const cv::Mat postures = cv::imread(paths[0]), unknown = cv::imread(paths[1]), looks = cv::imread(paths[2]);
  EXPECT_EQ(postures.cols, 500);
  EXPECT_EQ(looks.cols, 4 * 340);
  // Seen from -y: one robot left of the model, the other one right of it, and nothing where nobody stands.
  const auto busy = [&](double from, double to) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(postures(cv::Rect(static_cast<int>(from * 500), 120, static_cast<int>((to - from) * 500), 120)), mean, deviation);
    return deviation[0] + deviation[1] + deviation[2];
  };
  EXPECT_GT(busy(0.08, 0.33), 30);
  EXPECT_GT(busy(0.67, 0.92), 30);
  EXPECT_LT(busy(0.0, 0.05), 15);
  int green = 0;
  for (int y = 0; y < unknown.rows; ++y)
    for (int x = 0; x < unknown.cols; ++x) {
      const auto& p = unknown.at<cv::Vec3b>(y, x);
      green += p[1] > 1.6 * p[0] && p[1] > 1.6 * p[2];
    }
  EXPECT_GT(green, 1000);
  EXPECT_THROW(write_figures(run + "/none", run), Error);
}

}  // namespace
}  // namespace periplus::supervisor
