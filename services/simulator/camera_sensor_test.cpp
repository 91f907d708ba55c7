#include "services/simulator/camera_sensor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace periplus::simulator {
namespace {

TEST(CameraSensor, GainOffsetAndNoiseAreAsAskedFor) {
  ImageU8 image(200, 200, 3, 100);
  expose(image, {.gain = 1.03, .offset = 2, .noise = 2}, 5);
  double mean = 0, square = 0;
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x) {
      EXPECT_EQ(image.at(x, y, 0), image.at(x, y, 2));
      mean += image.at(x, y) / 4e4;
      square += image.at(x, y) * image.at(x, y) / 4e4;
    }
  EXPECT_NEAR(mean, 105, 0.05);                            // five standard errors
  EXPECT_NEAR(std::sqrt(square - mean * mean), 2, 0.07);   // rounding adds 1/12 to the variance
}

TEST(CameraSensor, SameSeedSameBytes) {
  ImageU8 a(64, 48, 3, 90), b = a, c = a;
  expose(a, {.noise = 2}, picture_seed(1, "run-1.view-1", "left"));
  expose(b, {.noise = 2}, picture_seed(1, "run-1.view-1", "left"));
  expose(c, {.noise = 2}, picture_seed(1, "run-1.view-1", "right"));
  EXPECT_EQ(a.data, b.data);
  EXPECT_NE(a.data, c.data);
  EXPECT_NE(picture_seed(1, "a", "left"), picture_seed(2, "a", "left"));
  EXPECT_EQ(picture_seed(1, "20260101-000000-bunny-v1", "left"), picture_seed(1, "20260202-000000-bunny-v1", "left"));
  EXPECT_NE(picture_seed(1, "20260101-000000-bunny-v1", "left"), picture_seed(1, "20260101-000000-bunny-v2", "left"));
}

TEST(CameraSensor, StaysInRangeAndMayBeBlank) {
  ImageU8 white(8, 8, 1, 255);
  expose(white, {.gain = 2}, 1);
  EXPECT_EQ(white.at(3, 3), 255);
  ImageU8 black(8, 8, 1, 0);
  expose(black, {.offset = -50}, 1);
  EXPECT_EQ(black.at(3, 3), 0);
  expose(black, {.blank = true}, 1);
  EXPECT_EQ(black.at(3, 3), 128);
}

}  // namespace
}  // namespace periplus::simulator
