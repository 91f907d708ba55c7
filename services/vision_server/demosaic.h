// Raw images behind a colour filter to rgb.
#pragma once

#include "common/geometry/image.h"
#include "common/geometry/mosaic.h"

namespace periplus::vision {

// Rgb, or the image itself where it has no mosaic. Each pixel keeps what was measured there; the other two colours are the means of
// its nearest neighbours that have them. The outermost rows and columns are copies of those beside them.
// Throws Error(vision_image_bad) for a mosaic of more than one value a pixel or less than 4 pixels a side.
ImageU8 demosaiced(ImageU8 raw, Mosaic mosaic);

}  // namespace periplus::vision
