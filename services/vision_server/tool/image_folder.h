// Images of a calibration on disk: which, which belong together, and what is in them. Every file is hostile until checked.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/geometry/image.h"

namespace periplus::vision {

struct ImageFile {
  std::string name, path;
};

// The images of `where`, by name: a folder (its .png, .jpg, .jpeg, .bmp, .pgm, .ppm and .pnm files) or a pattern of file names with * and ?
// ("data/left??.jpg"). Throws Error(bad_input) if there are none or more than 500, Error(io) if the folder cannot be read.
std::vector<ImageFile> images_of(const std::string& where);

// Left and right images of the same name, or else of the same last number in their names (left07.jpg, right07.jpg), in the order
// of the left ones. Throws BadViews naming each image without a partner, or with two.
std::vector<std::pair<ImageFile, ImageFile>> paired(const std::vector<ImageFile>& left, const std::vector<ImageFile>& right);

// Grey values of a PNG, JPEG, BMP or PNM of at most 8192 pixels a side. Throws Error(bad_input) with a sentence that does not name
// the file: another format, cut short, damaged, too large; Error(io) if it cannot be read.
ImageU8 load_grey(const std::string& path);

}  // namespace periplus::vision
