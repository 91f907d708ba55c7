#include "integration-tests/eyes_benchmark/pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::eyes_benchmark {
namespace {

constexpr int kFirstOctave = 3, kLastOctave = 7;
constexpr double kFalloff = 0.8;
constexpr int kDark[3] = {140, 128, 118}, kLevels = 32;   // rgb

void write(const std::string& path, const cv::Mat& picture) {
  bool written = false;
  try {
    written = cv::imwrite(path, picture);
  } catch (const cv::Exception&) {
  }
  require(written, ErrorCode::io, "cannot write " + path);
}

}  // namespace

ImageU8 weak_texture(int width, int height, std::uint64_t seed) {
  Random random(seed);
  cv::Mat sum = cv::Mat::zeros(height, width, CV_32F);
  double amplitude = 1;
  for (int octave = kFirstOctave; octave <= kLastOctave; ++octave, amplitude *= kFalloff) {
    cv::Mat coarse(1 << octave, 1 << octave, CV_32F), fine;
    for (int y = 0; y < coarse.rows; ++y)
      for (int x = 0; x < coarse.cols; ++x) coarse.at<float>(y, x) = static_cast<float>(random.uniform());
    cv::resize(coarse, fine, {width, height}, 0, 0, cv::INTER_CUBIC);
    sum += fine * amplitude;
  }
  cv::normalize(sum, sum, 0, 1, cv::NORM_MINMAX);
  ImageU8 out(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) out.at(x, y, c) = static_cast<std::uint8_t>(std::lround(kDark[c] + kLevels * sum.at<float>(y, x)));
  return out;
}

ImageU8 plain_picture(const std::array<std::uint8_t, 3>& rgb) {
  ImageU8 out(16, 16, 3);
  for (std::size_t i = 0; i < out.data.size(); ++i) out.data[i] = rgb[i % 3];
  return out;
}

ImageU8 to_grey(const ImageU8& rgb) {
  ImageU8 out(rgb.width, rgb.height);
  for (std::size_t i = 0; i < out.data.size(); ++i)
    out.data[i] = static_cast<std::uint8_t>(std::lround(0.299 * rgb.data[3 * i] + 0.587 * rgb.data[3 * i + 1] + 0.114 * rgb.data[3 * i + 2]));
  return out;
}

ImageU8 load_grey(const std::string& path) {
  const cv::Mat picture = cv::imread(path, cv::IMREAD_GRAYSCALE);
  require(!picture.empty(), ErrorCode::io, path + ": not a picture that can be read; PNG or JPEG is expected");
  ImageU8 out(picture.cols, picture.rows);
  picture.copyTo(cv::Mat(out.height, out.width, CV_8UC1, out.data.data()));
  return out;
}

void write_depth(const std::string& path, const ImageF& depth, double near, double far) {
  cv::Mat level(depth.height, depth.width, CV_8UC1), colour;
  for (int y = 0; y < depth.height; ++y)
    for (int x = 0; x < depth.width; ++x)
      level.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(std::lround(255 * std::clamp((far - depth.at(x, y)) / (far - near), 0.0, 1.0)));
  cv::applyColorMap(level, colour, cv::COLORMAP_TURBO);
  for (int y = 0; y < depth.height; ++y)
    for (int x = 0; x < depth.width; ++x)
      if (depth.at(x, y) <= 0) colour.at<cv::Vec3b>(y, x) = {0, 0, 0};
  write(path, colour);
}

void write_error(const std::string& path, const ImageF& depth, const ImageF& truth, const ImageU8& object, double full) {
  cv::Mat colour(depth.height, depth.width, CV_8UC3, cv::Scalar(60, 60, 60));
  for (int y = 0; y < depth.height; ++y)
    for (int x = 0; x < depth.width; ++x) {
      if (!object.at(x, y)) continue;
      cv::Vec3b& c = colour.at<cv::Vec3b>(y, x);
      c = {0, 0, 0};
      if (depth.at(x, y) <= 0) continue;
      const double e = std::clamp((depth.at(x, y) - truth.at(x, y)) / full, -1.0, 1.0);
      const auto faded = static_cast<std::uint8_t>(std::lround(255 * (1 - std::abs(e))));
      c = e > 0 ? cv::Vec3b(faded, faded, 255) : cv::Vec3b(255, faded, faded);
    }
  write(path, colour);
}

}  // namespace periplus::eyes_benchmark
