// Real stereo pairs with their true disparities, as Debian packages hold them (deploy/fetch-assets.sh --stereo).
#pragma once

#include <string>
#include <vector>

#include "common/geometry/image.h"
#include "services/vision_server/stereo_matcher.h"

namespace periplus::eyes_benchmark {

struct RealPair {
  std::string name, source;
  ImageU8 left, right;              // grey, rectified
  ImageF truth;                     // of the left eye [px], 0 where unknown
  vision::DisparityRange range;     // from 0 to beyond the greatest true disparity
};

// Aloe (Middlebury 2006) and Motorcycle (Middlebury 2014, a quarter of its size). Throws Error(io) that says how to fetch them.
std::vector<RealPair> load_real_pairs();

// Data of a .npy file of version 1.0 of little-endian floats with this shape; what is not finite becomes 0. Throws Error(bad_input)
// for another file.
ImageF parse_npy(const std::string& bytes, int width, int height);

}  // namespace periplus::eyes_benchmark
