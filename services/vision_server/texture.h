// How much of what is seen has texture enough to be matched. Matching plain surfaces finds little, and much of that is wrong: they
// look the same along a whole line.
#pragma once

#include "common/geometry/image.h"

namespace periplus::vision {

struct TextureSettings {
  int window_px = 7;            // side of the window, odd: what matching compares, and a little
  double above_noise = 2;       // times what noise alone gives
  double least_share = 0.5;     // of the object's pixels; a view with less is cautious, however much of it was matched
  void check() const;           // throws Error(bad_input)
};

// Standard deviation of the noise [grey levels], by Immerkaer's difference of Laplacians (1996) in blocks of 16 x 16: that of the
// block at the 5th percentile, as texture only adds; at least 0.5 and at most 4. 0.5 of an image smaller than a block.
double noise_of(const ImageU8& grey);

// 255 where the lesser eigenvalue of the structure tensor (Foerstner 1987; mean over the window of the products of Sobel gradients [grey
// levels a pixel]) is above `above_noise` times that of noise of standard deviation `noise`: grey levels change in every direction.
ImageU8 textured_pixels(const ImageU8& grey, double noise, const TextureSettings& settings);

}  // namespace periplus::vision
