#include "services/vision_server/calibration_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core/eigen.hpp>
#include <opencv2/core/persistence.hpp>

#include "common/core/config.h"
#include "common/core/file.h"
#include "services/vision_server/rectification.h"

namespace periplus::vision {
namespace {

PairFit some_pair() {
  PairFit f;
  for (CameraFit* c : {&f.left, &f.right}) {
    c->width = 640;
    c->height = 480;
    c->K << 536.25, 0, 342.5, 0, 535.75, 235.125, 0, 0, 1;
    c->distortion = {-0.28, 0.06, 0.0018, -0.0003, 0};
    c->views.resize(13);
  }
  f.T << -0.12, 0.001, 1.0 / 3;
  f.left_rectified = CameraCalibration::ideal({640, 480, 500, 500, 320, 240});
  f.right_rectified = CameraCalibration::ideal({640, 480, 500, 500, 320, 240}, 0.12);
  f.rms_px = 0.2;
  return f;
}

cv::FileStorage read(const std::string& yaml) { return {yaml, cv::FileStorage::READ | cv::FileStorage::MEMORY}; }

template <int Rows, int Cols>
Eigen::Matrix<double, Rows, Cols> matrix(const cv::FileStorage& file, const char* name) {
  cv::Mat m;
  file[name] >> m;
  Eigen::Matrix<double, Rows, Cols> out;
  EXPECT_EQ(m.rows, Rows) << name;
  EXPECT_EQ(m.cols, Cols) << name;
  if (m.rows == Rows && m.cols == Cols) cv::cv2eigen(m, out);
  return out;
}

TEST(CalibrationFile, OpenCVReadsBackEveryNumber) {
  const PairFit f = some_pair();
  const cv::FileStorage pair = read(pair_yaml(f, {9, 6, 0.025}));
  ASSERT_TRUE(pair.isOpened());
  EXPECT_EQ(static_cast<int>(pair["image_width"]), 640);
  EXPECT_EQ(static_cast<int>(pair["image_height"]), 480);
  EXPECT_EQ(static_cast<int>(pair["nframes"]), 13);
  EXPECT_EQ(static_cast<double>(pair["square_size"]), 0.025);
  EXPECT_EQ((matrix<3, 3>(pair, "M1")), f.left.K);
  EXPECT_EQ((matrix<3, 1>(pair, "T")), f.T);
  EXPECT_EQ((matrix<3, 3>(pair, "R")), f.R);
  EXPECT_EQ((matrix<3, 4>(pair, "P2")), f.right_rectified.P);
  EXPECT_EQ((matrix<1, 5>(pair, "D2")), (Eigen::Matrix<double, 1, 5>() << -0.28, 0.06, 0.0018, -0.0003, 0).finished());
  for (const char* name : {"E", "F", "R1", "R2", "P1", "Q", "M2", "D1"}) EXPECT_FALSE(pair[name].empty()) << name;

  const cv::FileStorage camera = read(camera_yaml(f.right, f.right_rectified, "right", {9, 6, 0.025}));
  EXPECT_EQ(static_cast<std::string>(camera["camera_name"]), "right");
  EXPECT_EQ(static_cast<std::string>(camera["distortion_model"]), "plumb_bob");
  EXPECT_EQ((matrix<3, 3>(camera, "camera_matrix")), f.right.K);
  EXPECT_EQ((matrix<3, 4>(camera, "projection_matrix")), f.right_rectified.P);
  EXPECT_EQ((matrix<3, 3>(camera, "rectification_matrix")), f.right_rectified.R);
}

TEST(CalibrationFile, TheCameraFileIsPeriplusYaml) {
  const PairFit f = some_pair();
  const config::Node node = config::parse(view_camera_yaml(rig_of(f.left_rectified, f.right_rectified), "stereo"), "view.yaml");
  EXPECT_EQ(node.get<std::string>("schema"), "periplus-camera-1");
  EXPECT_EQ(node.get<Eigen::Vector2d>("focal_px").x(), 500);
  EXPECT_EQ(node.get<Eigen::Vector2d>("center_px").y(), 240);
  EXPECT_NEAR(node.get<double>("baseline_m"), 0.12, 1e-12);
}

TEST(CalibrationFile, IsWrittenWholeOrNotAtAll) {
  const auto folder = std::filesystem::temp_directory_path() / "periplus_calibration_file_test";
  std::filesystem::remove_all(folder);
  write_files(folder.string(), {{"a.yaml", "one"}, {"b.yaml", "one"}});
  write_files(folder.string(), {{"a.yaml", "two"}, {"b.yaml", "two"}});
  EXPECT_EQ(read_file((folder / "a.yaml").string()), "two");
  // The last cannot be written: the others stay what they were.
  std::filesystem::create_directories(folder / "c.yaml");
  EXPECT_THROW(write_files(folder.string(), {{"a.yaml", "three"}, {"b.yaml", "three"}, {"c.yaml", "three"}}), Error);
  EXPECT_EQ(read_file((folder / "a.yaml").string()), "two");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 3);
  EXPECT_THROW(write_files((folder / "a.yaml").string(), {{"a.yaml", "x"}}), Error);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace periplus::vision
