// Pictures for surfaces: made from a seed, or read from a file.
#pragma once

#include <cstdint>
#include <string>

#include "common/geometry/image.h"

namespace periplus::render {

// Rich texture on all scales, which stereo matching and features find everywhere: noise in octaves, with coloured
// discs, frames and letters strewn over it. RGB; the same bytes for the same seed.
ImageU8 make_texture(int width, int height, std::uint64_t seed);

// Eight horizontal bands, one a mesh::Material, the first at the bottom: wood, canvas, leaves, stone and so on, each with rich
// texture along and across. RGB; the same bytes for the same seed.
ImageU8 make_materials(int width, int height, std::uint64_t seed);

// PNG or JPEG as RGB. Throws Error(io) if it cannot be read, Error(bad_size) above 8192 pixels a side.
ImageU8 load_texture(const std::string& path);

}  // namespace periplus::render
