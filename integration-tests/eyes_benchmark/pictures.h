// Pictures: what an object is painted with, and depth and errors for people to look at. OpenCV stands behind the source.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/geometry/image.h"

namespace periplus::eyes_benchmark {

// Noise in octaves, without marks, within 32 grey levels. RGB; the same bytes for the same seed.
ImageU8 weak_texture(int width, int height, std::uint64_t seed);
ImageU8 plain_picture(const std::array<std::uint8_t, 3>& rgb);

// ITU-R BT.601, as every camera driver has it.
ImageU8 to_grey(const ImageU8& rgb);

// PNG or JPEG, grey. Throws Error(io) if it cannot be read.
ImageU8 load_grey(const std::string& path);

// Both black where there is no depth (0). Depth: near red, far blue, from `near` to `far` [m]. Error: measured less true, white
// 0, red behind the truth by `full` [m] or more, blue before it; only where `object` is not 0.
void write_depth(const std::string& path, const ImageF& depth, double near, double far);
void write_error(const std::string& path, const ImageF& depth, const ImageF& truth, const ImageU8& object, double full);

}  // namespace periplus::eyes_benchmark
