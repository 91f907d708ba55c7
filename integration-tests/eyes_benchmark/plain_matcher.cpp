#include "integration-tests/eyes_benchmark/plain_matcher.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace periplus::eyes_benchmark {

ImageF plain_match(const ImageU8& left, const ImageU8& right, const vision::DisparityRange& range) {
  constexpr int kBlock = 5, kArea = kBlock * kBlock;
  const auto view = [](const ImageU8& image) { return cv::Mat(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data.data())); };
  cv::Mat raw;
  cv::StereoSGBM::create(range.least, range.count, kBlock, 8 * kArea, 32 * kArea, 1, 0, 10, 100, 2)->compute(view(left), view(right), raw);
  ImageF out(left.width, left.height);
  for (int y = 0; y < raw.rows; ++y)
    for (int x = 0; x < raw.cols; ++x) {
      const short d = raw.at<short>(y, x);
      if (d >= 16 * range.least && d > 0) out.at(x, y) = static_cast<float>(d) / 16;
    }
  return out;
}

void set_threads(int threads) { cv::setNumThreads(threads); }

}  // namespace periplus::eyes_benchmark
