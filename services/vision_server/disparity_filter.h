// Filling of a disparity map by comparison of image blocks: thesis 4.2.1.3, Algorithm 2. What is filled is a guess, wrong
// three times as often at edges: it serves pictures, the choice of pixels over which object_valid_share() counts
// (box_silhouette.h) and the search for a feature's counterpart in the right eye (features.h), never measuring or carving.
#pragma once

#include "common/geometry/image.h"

namespace periplus::vision {

struct FilledDisparity {
  ImageF disparity;  // [px]; 0 where there is none
  ImageU8 filled;    // 255 where `disparity` is a guess; 0 where it was matched, or is missing
};

// Each element without a value (0) that has valued elements to its left and right in its row gets their mean, weighted by
// the likeness of the 3x3 blocks of the grey left image: weight 1 / (1 + |I_b - I_bl|_1). Blocks at the border repeat the
// outermost pixels. Throws Error(bad_size) unless both have one size.
FilledDisparity fill_disparity(const ImageF& disparity, const ImageU8& left_grey);

}  // namespace periplus::vision
