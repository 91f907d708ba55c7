#include "common/geometry/camera.h"

#include <cmath>

#include "common/core/error.h"

namespace periplus {

namespace {
// Beyond what any lens does [px]; keeps projections in the range of integers.
constexpr double kFocalMin = 1e-3, kFocalMax = 1e6;
}  // namespace

Pinhole Pinhole::from_vertical_fov(int width, int height, double fovy_rad) {
  require(fovy_rad > 0 && fovy_rad < 3.1, ErrorCode::bad_input, "vertical field of view must lie in (0, 3.1) rad");
  Pinhole c;
  c.width = width;
  c.height = height;
  c.fx = c.fy = height / 2.0 / std::tan(fovy_rad / 2.0);
  c.cx = (width - 1) / 2.0;
  c.cy = (height - 1) / 2.0;
  c.check();
  return c;
}

double Pinhole::horizontal_fov() const { return 2 * std::atan(width / 2.0 / fx); }
double Pinhole::vertical_fov() const { return 2 * std::atan(height / 2.0 / fy); }

void Pinhole::check() const {
  require(width >= 1 && width <= 8192 && height >= 1 && height <= 8192, ErrorCode::bad_input,
          "camera image size must lie in 1..8192 pixels");
  require(fx >= kFocalMin && fx <= kFocalMax && fy >= kFocalMin && fy <= kFocalMax, ErrorCode::bad_input,
          "camera focal lengths must lie in 0.001..1000000 pixels");
  require(cx >= 0 && cx <= width && cy >= 0 && cy <= height, ErrorCode::bad_input,
          "camera principal point must lie within the image");
}

void StereoRig::check() const {
  camera.check();
  require(std::isfinite(baseline) && baseline > 0 && baseline < 10, ErrorCode::bad_input,
          "stereo baseline must lie in (0, 10) m");
}

}  // namespace periplus
