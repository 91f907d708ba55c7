#include "common/object_model/image_minimum.h"

#include <algorithm>
#include <limits>

namespace periplus::object_model {

const std::vector<float>& SquareMinimum::level(int level) {
  if (level == 0) return image_->data;
  Level& made = levels_[static_cast<std::size_t>(level - 1)];
  std::call_once(made.made, [&] {
    const std::vector<float>& from = this->level(level - 1);
    const int half = 1 << (level - 1);
    std::vector<float>& to = made.least;
    to.assign(from.size(), 0.0f);
    for (int y = 0; y + 2 * half <= height_; ++y) {
      const float* a = &from[static_cast<std::size_t>(y) * width_];
      const float* b = &from[static_cast<std::size_t>(y + half) * width_];
      float* out = &to[static_cast<std::size_t>(y) * width_];
      for (int x = 0; x + 2 * half <= width_; ++x) out[x] = std::min(std::min(a[x], a[x + half]), std::min(b[x], b[x + half]));
    }
  });
  return made.least;
}

BlockRange::BlockRange(const ImageF& image) : columns_((image.width + kSide - 1) / kSide) {
  const std::size_t blocks = static_cast<std::size_t>(columns_) * ((image.height + kSide - 1) / kSide);
  least_.assign(blocks, std::numeric_limits<float>::infinity());
  greatest_.assign(blocks, -std::numeric_limits<float>::infinity());
  for (int y = 0; y < image.height; ++y) {
    const float* row = &image.data[static_cast<std::size_t>(y) * image.width];
    float* least = &least_[static_cast<std::size_t>(y / kSide) * columns_];
    float* greatest = &greatest_[static_cast<std::size_t>(y / kSide) * columns_];
    for (int block = 0; block < columns_; ++block) {
      const int end = std::min(image.width, (block + 1) * kSide);
      float low = least[block], high = greatest[block];
      for (int x = block * kSide; x < end; ++x) {
        low = std::min(low, row[x]);
        high = std::max(high, row[x]);
      }
      least[block] = low;
      greatest[block] = high;
    }
  }
}

void BlockRange::range(int x0, int y0, int x1, int y1, float& least, float& greatest) const {
  least = std::numeric_limits<float>::infinity();
  greatest = -std::numeric_limits<float>::infinity();
  for (int y = y0 / kSide; y <= y1 / kSide; ++y) {
    for (int x = x0 / kSide; x <= x1 / kSide; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * columns_ + x;
      least = std::min(least, least_[at]);
      greatest = std::max(greatest, greatest_[at]);
    }
  }
}

}  // namespace periplus::object_model
