#include "services/vision_server/tool/calibration_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace periplus::vision {
namespace {

Calibrated three_pairs() {
  Calibrated c;
  c.pair.emplace();
  for (CameraFit* eye : {&c.pair->left, &c.pair->right}) {
    eye->width = 160;
    eye->height = 120;
    eye->distortion = {-0.25, 0.1, 0.001, 0.002, 0};
    for (const char* n : {"1", "2", "3"})
      eye->views.push_back({(eye == &c.pair->left ? "l" : "r") + std::string(n) + ".png", 0.2, 3, {{40, 60}, {100, 60}}, {{40, 60}, {100.5, 60}}});
  }
  c.pair->right.views[1].error_px = 0.7;  // the second pair is the worst, by its right eye
  return c;
}

TEST(CalibrationReport, TheWorstOfEitherEyeIsNamed) {
  Calibrated c = three_pairs();
  EXPECT_EQ(worst_view(c), 1u);
  EXPECT_EQ(nlohmann::json::parse(report_json(c)).at("worst"), "l2.png");
  const std::string text = report_text(c);
  EXPECT_NE(text.find("0.700          3.0   worst\n"), std::string::npos) << text;
  EXPECT_NE(text.find("squares"), std::string::npos);
  c.camera = c.pair->left;
  c.pair.reset();
  c.camera->views[2].error_px = 0.3;
  EXPECT_EQ(worst_view(c), 2u);
  EXPECT_EQ(nlohmann::json::parse(report_json(c)).at("images").size(), 3u);
}

TEST(CalibrationReport, ARefusalIsJsonWhateverTheNames) {
  const auto j = nlohmann::json::parse(refusal_json("why", {{"bad\xff\"name", "blurred"}}));
  EXPECT_EQ(j.at("result"), "refused");
  EXPECT_EQ(j.at("images")[0].at("why"), "blurred");
}

TEST(CalibrationReport, ThePictureShowsTheErrorTwentyTimesAsLong) {
  const std::string png = view_picture(three_pairs(), 0, {ImageU8(160, 120, 1, 128), ImageU8(160, 120, 1, 128)});
  const cv::Mat picture = cv::imdecode(std::vector<std::uint8_t>(png.begin(), png.end()), cv::IMREAD_COLOR);
  ASSERT_EQ(picture.cols, 1800);  // two eyes of 900
  const double scale = 900.0 / 160;
  const int band = picture.rows - static_cast<int>(120 * scale), y = band + static_cast<int>(60.5 * scale - 0.5);
  const auto is_yellow = [&](double x) {
    const auto p = picture.at<cv::Vec3b>(y, static_cast<int>((x + 0.5) * scale));
    return p[0] < 60 && p[1] > 180 && p[2] > 200;
  };
  EXPECT_TRUE(is_yellow(105));   // half a pixel of error at 100: a line to 110
  EXPECT_TRUE(is_yellow(108));
  EXPECT_FALSE(is_yellow(112));
  EXPECT_FALSE(is_yellow(45));   // none at 40
  EXPECT_TRUE(is_yellow(160 + 108));
}

}  // namespace
}  // namespace periplus::vision
