// Least values of a depth image over rectangles of pixels: what decides whether a voxel is seen through.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "common/geometry/image.h"

namespace periplus::object_model {

// Least value over every square of some sizes, by its upper left corner; made size by size as they are asked for, by whichever thread asks first.
class SquareMinimum {
 public:
  // `image` of one channel stays the caller's.
  explicit SquareMinimum(const ImageF& image) : width_(image.width), height_(image.height), image_(&image) {}

  // From 2 on each is at least two thirds of the next: the longest that fits into a rectangle's shorter side mostly covers either side twice.
  static constexpr std::array<int, 12> kSides{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64};  // [px]
  // Index of the longest of these sides that is no longer than `most`, which is at least 1.
  static std::size_t index_of(int most);

  // Row by row, of the image's size; squares that reach beyond the image are absent (0). kSides[index] is at most the image's shorter side.
  const float* least(std::size_t index);

 private:
  int width_, height_;
  const ImageF* image_;
  struct Made {
    std::once_flag once;
    std::unique_ptr<float[]> least;
  };
  std::array<Made, kSides.size()> made_;
};

// Least and greatest value over blocks of 8 x 8 pixels.
class BlockRange {
 public:
  static constexpr int kSide = 8;

  explicit BlockRange(const ImageF& image);
  // Over the blocks that pixels x0..x1, y0..y1 (inside the image) lie in: `least` is no more, `greatest` no less than theirs.
  void range(int x0, int y0, int x1, int y1, float& least, float& greatest) const;

 private:
  int columns_ = 0;
  std::vector<float> least_, greatest_;
};

}  // namespace periplus::object_model
