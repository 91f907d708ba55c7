// cv::StereoSGBM as its documentation proposes, the baseline of every row; OpenCV stands behind the source.
#pragma once

#include "common/geometry/image.h"
#include "services/vision_server/stereo_matcher.h"

namespace periplus::eyes_benchmark {

// Disparity [px] of the left image, 0 where there is none: blocks of 5, P1 = 8 * 25, P2 = 32 * 25, disp12MaxDiff 1, uniqueness 10,
// speckles of 100 px / 2 px, five directions.
ImageF plain_match(const ImageU8& left, const ImageU8& right, const vision::DisparityRange& range);

// OpenCV's, as vision_server sets it.
void set_threads(int threads);

}  // namespace periplus::eyes_benchmark
