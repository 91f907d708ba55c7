#include "common/object_model/image_minimum.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "common/voxel/simd_function.h"

namespace periplus::object_model {

namespace {

// Of squares of `side` pixels from those of `of` pixels, no less than half as long: the least of the four in its corners.
PERIPLUS_INLINE void squares_body(const float* __restrict from, int width, int height, int of, int side, float* __restrict to) {
  const std::int64_t shift = side - of;
  for (int y = 0; y < height; ++y) {
    const float *a = from + std::int64_t{y} * width, *b = a + shift * width;
    float* out = to + std::int64_t{y} * width;
    const int columns = y + side <= height ? std::max(width - side + 1, 0) : 0;
    for (int x = 0; x < columns; ++x) out[x] = std::min(std::min(a[x], a[x + shift]), std::min(b[x], b[x + shift]));
    for (int x = columns; x < width; ++x) out[x] = 0;
  }
}
PERIPLUS_SIMD_FUNCTION(void, squares, (const float* from, int width, int height, int of, int side, float* to), (from, width, height, of, side, to))

// Ranges of the columns of some rows.
PERIPLUS_INLINE void columns_body(const float* __restrict rows, std::int64_t width, int count, float* __restrict low, float* __restrict high) {
  for (int y = 0; y < count; ++y) {
    for (std::int64_t x = 0; x < width; ++x) {
      const float v = rows[y * width + x];
      low[x] = y == 0 ? v : std::min(low[x], v);
      high[x] = y == 0 ? v : std::max(high[x], v);
    }
  }
}
PERIPLUS_SIMD_FUNCTION(void, columns, (const float* rows, std::int64_t width, int count, float* low, float* high), (rows, width, count, low, high))

}  // namespace

std::size_t SquareMinimum::index_of(int most) {
  return static_cast<std::size_t>(std::upper_bound(kSides.begin(), kSides.end(), most) - kSides.begin() - 1);
}

const float* SquareMinimum::least(std::size_t index) {
  if (index == 0) return image_->data.data();
  Made& made = made_[index];
  std::call_once(made.once, [&] {
    // Of the side half as long, or, for three halves of a power of two, of that power.
    const std::size_t from = index == 1 ? 0 : index % 2 == 0 ? index - 1 : index - 2;
    const float* smaller = least(from);
    made.least = std::make_unique_for_overwrite<float[]>(image_->data.size());
    squares_for(voxel::Simd::best)(smaller, width_, height_, kSides[from], kSides[index], made.least.get());
  });
  return made.least.get();
}

BlockRange::BlockRange(const ImageF& image) : columns_((image.width + kSide - 1) / kSide) {
  const std::size_t blocks = static_cast<std::size_t>(columns_) * ((image.height + kSide - 1) / kSide);
  least_.assign(blocks, std::numeric_limits<float>::infinity());
  greatest_.assign(blocks, -std::numeric_limits<float>::infinity());
  const auto width = static_cast<std::size_t>(image.width);
  std::vector<float> low(width), high(width);  // of the columns of a row of blocks
  for (int y = 0; y < image.height; y += kSide) {
    columns_for(voxel::Simd::best)(&image.data[static_cast<std::size_t>(y) * width], image.width, std::min(kSide, image.height - y), low.data(), high.data());
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t block = static_cast<std::size_t>(y / kSide) * columns_ + x / kSide;
      least_[block] = std::min(least_[block], low[x]);
      greatest_[block] = std::max(greatest_[block], high[x]);
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
