#include "services/vision_server/disparity_filter.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace periplus::vision {

FilledDisparity fill_disparity(const ImageF& disparity, const ImageU8& left_grey) {
  require(disparity.width == left_grey.width && disparity.height == left_grey.height && left_grey.channels == 1 &&
              disparity.channels == 1,
          ErrorCode::bad_size, "the disparity filter needs a disparity map and a grey image of one size");
  const int w = disparity.width, h = disparity.height;
  const auto block_distance = [&](int x0, int x1, int y) {
    int sum = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      const int yy = std::clamp(y + dy, 0, h - 1);
      for (int dx = -1; dx <= 1; ++dx)
        sum += std::abs(static_cast<int>(left_grey.at(std::clamp(x0 + dx, 0, w - 1), yy)) -
                        static_cast<int>(left_grey.at(std::clamp(x1 + dx, 0, w - 1), yy)));
    }
    return sum;
  };
  FilledDisparity out{disparity, ImageU8(w, h)};
  std::vector<int> next(static_cast<std::size_t>(w) + 1);
  for (int y = 0; y < h; ++y) {
    next[static_cast<std::size_t>(w)] = w;
    for (int x = w - 1; x >= 0; --x)
      next[static_cast<std::size_t>(x)] = disparity.at(x, y) > 0 ? x : next[static_cast<std::size_t>(x) + 1];
    int left = -1;
    for (int x = 0; x < w; ++x) {
      if (disparity.at(x, y) > 0) {
        left = x;
        continue;
      }
      const int right = next[static_cast<std::size_t>(x)];
      if (left < 0 || right >= w) continue;
      const double wl = 1.0 / (1 + block_distance(x, left, y)), wr = 1.0 / (1 + block_distance(x, right, y));
      out.disparity.at(x, y) = static_cast<float>((wl * disparity.at(left, y) + wr * disparity.at(right, y)) / (wl + wr));
      out.filled.at(x, y) = 255;
    }
  }
  return out;
}

}  // namespace periplus::vision
