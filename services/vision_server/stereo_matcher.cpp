#include "services/vision_server/stereo_matcher.h"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <utility>

#include "common/core/error.h"
#include "services/vision_server/beside.h"

namespace periplus::vision {

namespace {

cv::Mat flipped(const cv::Mat& image) {
  cv::Mat out;
  cv::flip(image, out, 1);
  return out;
}

// Disparity of `reference`, whose matches lie further left in `other`; 0 where there is none.
cv::Mat one_way(const cv::Mat& reference, const cv::Mat& other, const DisparityRange& range, const MatchSettings& s) {
  // OpenCV leaves the leftmost least + count columns without disparity: give them a border to search in.
  const int pad = range.least + range.count;
  cv::Mat a, b, raw;
  cv::copyMakeBorder(reference, a, 0, 0, pad, 0, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(other, b, 0, 0, pad, 0, cv::BORDER_REPLICATE);
  const int area = s.block * s.block;
  auto sgbm = cv::StereoSGBM::create(range.least, range.count, s.block, s.penalty_1 * area, s.penalty_2 * area, -1,
                                     s.prefilter_cap, s.uniqueness_percent, s.speckle_window, s.speckle_range,
                                     cv::StereoSGBM::MODE_SGBM_3WAY);
  sgbm->compute(a, b, raw);
  cv::Mat out(reference.size(), CV_32F);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      const short d = raw.at<short>(y, x + pad);
      out.at<float>(y, x) = d < range.least * 16 || d <= 0 ? 0.f : static_cast<float>(d) / 16.f;
    }
  return out;
}

// Keeps what the other eye confirms. `sign` is -1 where matches lie further left (left eye), +1 for the right eye.
ImageF confirmed(const cv::Mat& mine, const cv::Mat& theirs, int sign, double tolerance) {
  ImageF out(mine.cols, mine.rows);
  for (int y = 0; y < mine.rows; ++y)
    for (int x = 0; x < mine.cols; ++x) {
      const float d = mine.at<float>(y, x);
      if (d <= 0) continue;
      const int there = static_cast<int>(std::lround(x + sign * d));
      if (there < 0 || there >= mine.cols) continue;
      const float back = theirs.at<float>(y, there);
      if (back > 0 && std::abs(back - d) <= tolerance) out.at(x, y) = d;
    }
  return out;
}

cv::Mat view(const ImageU8& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data.data())};
}

}  // namespace

void MatchSettings::check() const {
  require(block >= 1 && block <= 21 && block % 2 == 1, ErrorCode::bad_input, "matching: block_px must be odd and in 1..21");
  require(penalty_1 > 0 && penalty_2 > penalty_1, ErrorCode::bad_input,
          "matching: penalty_2 must exceed penalty_1, and both 0");
  require(prefilter_cap >= 1 && prefilter_cap <= 63, ErrorCode::bad_input, "matching: prefilter_cap must lie in 1..63");
  require(uniqueness_percent >= 0 && uniqueness_percent < 100, ErrorCode::bad_input,
          "matching: uniqueness_percent must lie in 0..99");
  // Costs are numbers of 16 bits: beyond that they wrap, and wrong matches win.
  constexpr int kMostPenalty = 20000;
  require(penalty_2 <= kMostPenalty / (block * block), ErrorCode::bad_input,
          "matching: penalty_2 times block_px squared must not exceed " + std::to_string(kMostPenalty) + ": with block_px " + std::to_string(block) + " at most " +
              std::to_string(kMostPenalty / (block * block)));
  require(speckle_window >= 0 && speckle_range >= 0 && speckle_range <= kMostDisparity, ErrorCode::bad_input, "matching: speckle sizes must not be negative, speckle_range_px at most 2047");
  require(left_right_px > 0, ErrorCode::bad_input, "matching: left_right_px must be positive");
}

DisparityPair match(const ImageU8& left, const ImageU8& right, const DisparityRange& range,
                    const MatchSettings& settings) {
  settings.check();
  require(left.channels == 1 && right.channels == 1 && left.width == right.width && left.height == right.height &&
              left.width > 0 && left.height > 0,
          ErrorCode::bad_size, "stereo matching needs two grey images of one size");
  require(range.least >= 0 && range.count > 0 && range.count % 16 == 0 && range.least + range.count <= kMostDisparity + 1, ErrorCode::bad_input,
          "the disparity range must be a positive multiple of 16 pixels, and end at 2047");
  require(range.least + range.count < 4 * left.width, ErrorCode::bad_input,
          "images " + std::to_string(left.width) + " px wide cannot show disparities of " + std::to_string(range.least) + " to " + std::to_string(range.least + range.count - 1) +
              " px, which room and object ask for; send larger images");
  const cv::Mat l = view(left), r = view(right);
  // Both eyes at once: OpenCV spreads only parts of the work over its threads.
  auto right_way = beside([&] { return flipped(one_way(flipped(r), flipped(l), range, settings)); });
  const cv::Mat of_left = one_way(l, r, range, settings);
  const cv::Mat of_right = right_way.get();
  auto right_confirmed = beside([&] { return confirmed(of_right, of_left, +1, settings.left_right_px); });
  ImageF left_confirmed = confirmed(of_left, of_right, -1, settings.left_right_px);
  return {std::move(left_confirmed), right_confirmed.get()};
}

}  // namespace periplus::vision
