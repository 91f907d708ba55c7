// Images as plain row-major arrays, without a library.
#pragma once

#include <cstdint>
#include <vector>

#include "common/core/error.h"

namespace periplus {

// `channels` values a pixel, interleaved.
template <class T>
struct Image {
  int width = 0, height = 0, channels = 1;
  std::vector<T> data;

  Image() = default;
  Image(int w, int h, int c = 1, T fill = T{})
      : width(w), height(h), channels(c), data(static_cast<std::size_t>(w) * h * c, fill) {}

  bool empty() const { return data.empty(); }
  T& at(int x, int y, int c = 0) { return data[(static_cast<std::size_t>(y) * width + x) * channels + c]; }
  const T& at(int x, int y, int c = 0) const { return data[(static_cast<std::size_t>(y) * width + x) * channels + c]; }
};

using ImageU8 = Image<std::uint8_t>;   // grey (1) or rgb (3)
using ImageF = Image<float>;           // depth [m], disparity [px]; 0 where there is none

}  // namespace periplus
