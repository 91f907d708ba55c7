// Dense stereo by semi-global block matching (Hirschmueller 2008; OpenCV's StereoSGBM; thesis 4.2.1.2) with a
// left-right check of its own, which OpenCV's three-way mode lacks.
#pragma once

#include "common/geometry/image.h"

namespace periplus::vision {

struct MatchSettings {
  int block = 5;                    // side of the matched block [px], odd
  int penalty_1 = 4;                // smoothness, per pixel of the block: disparity changes by 1 ...
  int penalty_2 = 24;               // ... and by more
  int prefilter_cap = 31;
  int uniqueness_percent = 20;      // by how much the best match must beat the second
  int speckle_window = 200;         // smaller patches are dropped [px]
  int speckle_range = 2;            // [px]
  double left_right_px = 0.75;      // both eyes must agree to this
  // Throws Error(bad_input) naming the parameter.
  void check() const;
};

// OpenCV gives disparities in sixteenths, as numbers of 16 bits.
constexpr int kMostDisparity = 2047;

// Disparities least .. least + count - 1 are searched; count is a multiple of 16.
struct DisparityRange {
  int least = 0;
  int count = 16;
};

// Disparities [px] in sixteenths, 0 where there is none: of the left image (x_left - x_right) and of the right one.
struct DisparityPair {
  ImageF left, right;
};

// Rectified grey images of one size. The same bytes whatever cv::setNumThreads says. Throws Error(bad_size) for other shapes.
DisparityPair match(const ImageU8& left, const ImageU8& right, const DisparityRange& range, const MatchSettings& settings);

}  // namespace periplus::vision
