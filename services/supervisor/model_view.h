// Pictures of a coloured model: orthographic, shaded, without a display.
#pragma once

#include <string>
#include <vector>

#include "common/geometry/image.h"

namespace periplus::supervisor {

struct ModelView {
  std::string name;   // front, left, back, right, above
  ImageU8 image;      // rgb, square
};

// The model (PLY, metres, z up) from four sides, 20 degrees from above, and from straight above; empty if there is no such file.
std::vector<ModelView> model_views(const std::string& ply_path, int size_px);

}  // namespace periplus::supervisor
