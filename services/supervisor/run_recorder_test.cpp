#include "services/supervisor/run_recorder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "common/core/error.h"

namespace periplus::supervisor {
namespace {

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream s;
  s << file.rdbuf();
  return s.str();
}

std::string fresh_folder() {
  const std::string folder = testing::TempDir() + "/run_recorder_test";
  std::filesystem::remove_all(folder);
  return folder;
}

TEST(RunRecorder, DepthIsWrittenAsNumpyReadsIt) {
  RunRecorder recorder(fresh_folder());
  object_model::Perception p;
  p.depth.resize(1);
  p.depth[0].depth = ImageF(3, 2);
  p.depth[0].depth.at(2, 1) = 1.5f;
  p.color = ImageU8(3, 2, 3, 100);
  recorder.save_perception(1, p);
  const std::string bytes = read(recorder.look_folder(1) + "/depth.npy");
  EXPECT_EQ(bytes.substr(1, 5), "NUMPY");
  const std::size_t header = 10 + static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
  EXPECT_EQ(header % 64, 0u);
  EXPECT_NE(bytes.find("'shape': (2, 3, )"), std::string::npos);
  ASSERT_EQ(bytes.size(), header + 6 * sizeof(float));
  float last;
  std::memcpy(&last, bytes.data() + header + 5 * sizeof(float), sizeof last);
  EXPECT_EQ(last, 1.5f);
  EXPECT_TRUE(std::filesystem::exists(recorder.look_folder(1) + "/depth.png"));
  EXPECT_TRUE(std::filesystem::exists(recorder.look_folder(1) + "/color.png"));
}

TEST(RunRecorder, GuessedDisparitiesAreShownAsSuch) {
  RunRecorder recorder(fresh_folder());
  object_model::Perception p;
  p.disparity = ImageF(2, 1, 1, 20.f);
  p.disparity_filled = ImageU8(2, 1);
  p.disparity_filled.at(1, 0) = 255;
  recorder.save_perception(1, p);
  const cv::Mat picture = cv::imread(recorder.look_folder(1) + "/disparity.png"), mask = cv::imread(recorder.look_folder(1) + "/disparity_filled.png");
  ASSERT_EQ(picture.cols, 2);
  const cv::Vec3b measured = picture.at<cv::Vec3b>(0, 0), guessed = picture.at<cv::Vec3b>(0, 1);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(guessed[c], measured[c] / 2.0, 1);
  EXPECT_EQ(mask.at<cv::Vec3b>(0, 0)[0], 0);
  EXPECT_EQ(mask.at<cv::Vec3b>(0, 1)[0], 255);
}

TEST(RunRecorder, LookJsonCarriesPoseRowByRowAndNoPredictionForTheFirst) {
  RunRecorder recorder(fresh_folder());
  LookRecord look;
  look.look = 1;
  look.X_WC.translation() << 1, 2, 3;
  look.seconds = {{"walk", 1.0}, {"next_view", 2.0}, {"next_view", 0.5}};
  recorder.save_look(look, {Pinhole::from_vertical_fov(640, 480, 0.5), 0.144});
  const nlohmann::json j = nlohmann::json::parse(read(recorder.look_folder(1) + "/look.json"));
  EXPECT_EQ(j["pose_world_camera"][2][3], 3.0);
  EXPECT_TRUE(j["predicted_gain_px"].is_null());
  EXPECT_EQ(j["seconds"]["next_view"], 2.5);
}

TEST(RunRecorder, AFinishedRunIsNotOverwritten) {
  const std::string folder = fresh_folder();
  RunRecorder(folder).save_text("report.json", "{}");
  EXPECT_THROW(RunRecorder{folder}, Error);
  EXPECT_THROW(RunRecorder{"/proc/no"}, Error);
}

}  // namespace
}  // namespace periplus::supervisor
