// Pictures of a coloured model: orthographic, shaded, without a display.
#pragma once

#include <string>
#include <vector>

#include "common/geometry/image.h"
#include "common/mesh/triangle_mesh.h"

namespace periplus::supervisor {

struct ModelView {
  std::string name;   // front, left, back, right, above
  ImageU8 image;      // rgb, square
};

// The model (PLY, metres, z up) from four sides, 20 degrees from above, and from straight above; empty if there is no such file.
std::vector<ModelView> model_views(const std::string& ply_path, int size_px);

// A mesh with its vertices' colours seen from a direction [rad], azimuth from +x to +y, elevation upwards; square, and at a scale that
// holds `frame` from any side.
ImageU8 draw_model(const mesh::TriangleMesh& mesh, double azimuth, double elevation, int size_px, const mesh::Bounds& frame);

}  // namespace periplus::supervisor
