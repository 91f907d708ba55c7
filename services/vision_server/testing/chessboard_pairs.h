// The 13 real chessboard pairs of Debian's opencv-doc, 640 x 480, 9 x 6 corners (`deploy/fetch-assets.sh --calibration`).
#pragma once

#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/geometry/image.h"
#include "common/mesh/assets.h"

namespace periplus::vision::testing {

struct NamedImage {
  std::string name, path;
  ImageU8 grey;
};

inline NamedImage chessboard_image(const std::string& name) {
  NamedImage image{name, mesh::find_asset("calibration/" + name), {}};
  const cv::Mat grey = cv::imread(image.path, cv::IMREAD_GRAYSCALE);
  image.grey = ImageU8(grey.cols, grey.rows);
  grey.copyTo(cv::Mat(grey.rows, grey.cols, CV_8U, image.grey.data.data()));
  return image;
}

inline std::vector<std::pair<NamedImage, NamedImage>> chessboard_pairs() {
  std::vector<std::pair<NamedImage, NamedImage>> out;
  for (int n = 1; n <= 14; ++n) {
    if (n == 10) continue;  // there is none
    char name[40];
    std::snprintf(name, sizeof name, "left%02d.jpg", n);
    NamedImage left = chessboard_image(name);
    std::snprintf(name, sizeof name, "right%02d.jpg", n);
    out.emplace_back(std::move(left), chessboard_image(name));
  }
  return out;
}

}  // namespace periplus::vision::testing
