#include "services/vision_server/demosaic.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace periplus::vision {
namespace {

struct Pattern {
  Mosaic mosaic;
  const char* colours;  // of the first two pixels of the first row, then of the second
};
constexpr Pattern kPatterns[] = {
    {Mosaic::rggb, "rggb"}, {Mosaic::bggr, "bggr"}, {Mosaic::gbrg, "gbrg"}, {Mosaic::grbg, "grbg"}};

int channel(const char* colours, int x, int y) { return static_cast<int>(std::string("rgb").find(colours[2 * (y % 2) + x % 2])); }

// What a camera with that filter sees of a picture.
ImageU8 seen_through(const Pattern& pattern, const ImageU8& picture) {
  ImageU8 raw(picture.width, picture.height);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) raw.at(x, y) = picture.at(x, y, channel(pattern.colours, x, y));
  return raw;
}

TEST(Demosaic, APlainColourComesBackEverywhere) {
  for (const Pattern& pattern : kPatterns)
    for (const int width : {4, 7, 16, 33})
      for (const int height : {4, 5, 18}) {
        ImageU8 picture(width, height, 3);
        for (std::size_t i = 0; i < picture.data.size(); ++i) picture.data[i] = static_cast<std::uint8_t>(i % 3 == 0 ? 200 : i % 3 == 1 ? 90 : 20);
        EXPECT_EQ(demosaiced(seen_through(pattern, picture), pattern.mosaic).data, picture.data) << pattern.colours << " " << width << " x " << height;
      }
}

// Colours that change evenly are met exactly by means of neighbours; one pixel aside or two colours swapped would be seen.
TEST(Demosaic, EachColourStandsWhereItWasMeasured) {
  ImageU8 picture(21, 18, 3);
  for (int y = 0; y < 18; ++y)
    for (int x = 0; x < 21; ++x) {
      picture.at(x, y, 0) = static_cast<std::uint8_t>(20 + 8 * x);
      picture.at(x, y, 1) = static_cast<std::uint8_t>(250 - 8 * y);
      picture.at(x, y, 2) = static_cast<std::uint8_t>(30 + 4 * x + 6 * y);
    }
  for (const Pattern& pattern : kPatterns) {
    const ImageU8 rgb = demosaiced(seen_through(pattern, picture), pattern.mosaic);
    for (int y = 1; y < 17; ++y)
      for (int x = 1; x < 20; ++x) {
        EXPECT_EQ(rgb.at(x, y, channel(pattern.colours, x, y)), picture.at(x, y, channel(pattern.colours, x, y))) << pattern.colours;
        for (int c = 0; c < 3; ++c) EXPECT_LE(std::abs(rgb.at(x, y, c) - picture.at(x, y, c)), 1) << pattern.colours << " " << x << " " << y << " " << c;
      }
  }
}

TEST(Demosaic, WhatHasNoMosaicStaysAndWhatIsNoneIsRefused) {
  ImageU8 grey(3, 2, 1, 7);
  EXPECT_EQ(demosaiced(grey, Mosaic::none).data, grey.data);
  EXPECT_THROW(demosaiced(grey, Mosaic::rggb), Error);
  EXPECT_THROW(demosaiced(ImageU8(8, 8, 3), Mosaic::rggb), Error);
}

}  // namespace
}  // namespace periplus::vision
