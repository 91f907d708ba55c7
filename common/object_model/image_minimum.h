// Least values of a depth image over rectangles of pixels: what decides whether a voxel is seen through.
#pragma once

#include <array>
#include <mutex>
#include <vector>

#include "common/geometry/image.h"

namespace periplus::object_model {

// Least value over every square of 2^level pixels, by its upper left corner; made level by level as far as they are asked for, by whichever
// thread asks first.
class SquareMinimum {
 public:
  // `image` of one channel stays the caller's.
  explicit SquareMinimum(const ImageF& image) : width_(image.width), height_(image.height), image_(&image) {}

  static constexpr int kGreatestLevel = 6;  // squares of 64 pixels

  // Row by row, of the image's size; squares that reach beyond the image are absent (0). 2^level is at most the shorter side, level at most
  // kGreatestLevel.
  const std::vector<float>& level(int level);
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_, height_;
  const ImageF* image_;
  struct Level {
    std::once_flag made;
    std::vector<float> least;
  };
  std::array<Level, kGreatestLevel> levels_;  // from level 1 on
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
