#include "services/vision_server/texture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/core/error.h"

namespace periplus::vision {

namespace {

constexpr int kNoiseBlock = 16;
constexpr double kLeastNoise = 0.5, kMostNoise = 4, kNoiseQuantile = 0.05;
constexpr double kGradientOfNoise = 12.0 / 64;  // variance of Sobel's gradient, divided by 8, of noise of variance 1

}  // namespace

void TextureSettings::check() const {
  require(window_px >= 3 && window_px <= 31 && window_px % 2 == 1, ErrorCode::bad_input, "texture: window_px must be odd and in 3..31");
  require(above_noise > 0 && std::isfinite(above_noise), ErrorCode::bad_input, "texture: above_noise must be positive");
  require(least_share >= 0 && least_share <= 1, ErrorCode::bad_input, "texture: least_share must lie in 0..1");
}

double noise_of(const ImageU8& grey) {
  const int w = grey.width, h = grey.height;
  std::vector<double> blocks;
  for (int y0 = 1; y0 + kNoiseBlock < h; y0 += kNoiseBlock)
    for (int x0 = 1; x0 + kNoiseBlock < w; x0 += kNoiseBlock) {
      int sum = 0;
      for (int y = y0; y < y0 + kNoiseBlock; ++y) {
        const std::uint8_t *a = &grey.at(x0, y - 1), *b = &grey.at(x0, y), *c = &grey.at(x0, y + 1);
        for (int x = 0; x < kNoiseBlock; ++x)
          sum += std::abs(a[x - 1] + a[x + 1] + c[x - 1] + c[x + 1] - 2 * (a[x] + b[x - 1] + b[x + 1] + c[x]) + 4 * b[x]);
      }
      blocks.push_back(std::sqrt(std::numbers::pi / 2) / 6 * sum / (kNoiseBlock * kNoiseBlock));
    }
  if (blocks.empty()) return kLeastNoise;
  const auto at = blocks.begin() + static_cast<std::ptrdiff_t>(kNoiseQuantile * static_cast<double>(blocks.size()));
  std::nth_element(blocks.begin(), at, blocks.end());
  return std::clamp(*at, kLeastNoise, kMostNoise);
}

ImageU8 textured_pixels(const ImageU8& grey, double noise, const TextureSettings& settings) {
  settings.check();
  require(grey.channels == 1, ErrorCode::bad_size, "texture is measured in a grey image");
  ImageU8 out(grey.width, grey.height);
  if (grey.empty()) return out;
  const cv::Mat image(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data.data()));
  cv::Mat gx, gy, xx, yy, xy;
  // Whole numbers, so that sums are the same in whatever order they are taken.
  cv::Sobel(image, gx, CV_16S, 1, 0, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::Sobel(image, gy, CV_16S, 0, 1, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::Mat fx, fy;
  gx.convertTo(fx, CV_32S);
  gy.convertTo(fy, CV_32S);
  const cv::Size window(settings.window_px, settings.window_px);
  cv::boxFilter(cv::Mat(fx.mul(fx)), xx, CV_32S, window, {-1, -1}, false, cv::BORDER_REPLICATE);
  cv::boxFilter(cv::Mat(fy.mul(fy)), yy, CV_32S, window, {-1, -1}, false, cv::BORDER_REPLICATE);
  cv::boxFilter(cv::Mat(fx.mul(fy)), xy, CV_32S, window, {-1, -1}, false, cv::BORDER_REPLICATE);
  const double least = settings.above_noise * kGradientOfNoise * noise * noise * 64 * window.area();
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const double a = xx.at<int>(y, x), b = yy.at<int>(y, x), c = xy.at<int>(y, x);
      if ((a + b) / 2 - std::sqrt((a - b) * (a - b) / 4 + c * c) > least) out.at(x, y) = 255;
    }
  return out;
}

}  // namespace periplus::vision
