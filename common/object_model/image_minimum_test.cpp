#include "common/object_model/image_minimum.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/core/random.h"

namespace periplus::object_model {
namespace {

ImageF noise(int width, int height) {
  Random random(9);
  ImageF image(width, height);
  for (float& v : image.data) v = static_cast<float>(random.uniform(0, 5));
  return image;
}

float least_of(const ImageF& image, int x0, int y0, int x1, int y1) {
  float least = image.at(x0, y0);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) least = std::min(least, image.at(x, y));
  }
  return least;
}

TEST(SquareMinimum, IsTheLeastOfEachSquare) {
  const ImageF image = noise(37, 29);
  SquareMinimum squares(image);
  for (const std::size_t index : {7, 0, 8, 4, 3, 1, 2, 5, 6}) {
    const float* values = squares.least(index);
    const int side = SquareMinimum::kSides[index];
    for (int y = 0; y + side <= 29; ++y) {
      for (int x = 0; x + side <= 37; ++x) ASSERT_EQ(values[static_cast<std::size_t>(y) * 37 + x], least_of(image, x, y, x + side - 1, y + side - 1));
    }
  }
}

TEST(SquareMinimum, OffersTheLongestSideThatFits) {
  for (int most = 1; most <= 70; ++most) {
    const std::size_t index = SquareMinimum::index_of(most);
    EXPECT_LE(SquareMinimum::kSides[index], most);
    if (index + 1 < SquareMinimum::kSides.size()) {
      EXPECT_GT(SquareMinimum::kSides[index + 1], most);
    }
  }
}

TEST(BlockRange, EnclosesEveryRectangle) {
  const ImageF image = noise(37, 29);
  const BlockRange blocks(image);
  Random random(10);
  for (int i = 0; i < 500; ++i) {
    const int x0 = random.below(37), y0 = random.below(29), x1 = x0 + random.below(37 - x0), y1 = y0 + random.below(29 - y0);
    float least, greatest;
    blocks.range(x0, y0, x1, y1, least, greatest);
    constexpr int s = BlockRange::kSide;
    EXPECT_EQ(least, least_of(image, x0 / s * s, y0 / s * s, std::min(36, x1 / s * s + s - 1), std::min(28, y1 / s * s + s - 1)));
    EXPECT_GE(greatest, image.at(x1, y1));
    EXPECT_LE(greatest, *std::max_element(image.data.begin(), image.data.end()));
  }
}

}  // namespace
}  // namespace periplus::object_model
