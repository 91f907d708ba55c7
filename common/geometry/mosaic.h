// Colour filters of raw images.
#pragma once

namespace periplus {

// How the filters lie: those of the first two pixels of the first row, then those of the second, as ROS names them (OpenCV's names for
// the same begin at the second pixel of the second row). `none`: grey or rgb as it stands.
enum class Mosaic { none, rggb, bggr, gbrg, grbg };

}  // namespace periplus
