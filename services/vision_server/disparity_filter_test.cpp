#include "services/vision_server/disparity_filter.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace periplus::vision {
namespace {

TEST(DisparityFilter, WeighsBothSidesByTheLikenessOfTheirBlocks) {
  // Columns of grey 10 10 10 10 40 40 40; the gap at x = 2 looks like its left neighbour.
  ImageU8 grey(7, 3);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 7; ++x) grey.at(x, y) = x < 4 ? 10 : 40;
  ImageF d(7, 3, 1, 0.f);
  d.at(1, 1) = 20;
  d.at(4, 1) = 8;
  const ImageF out = fill_disparity(d, grey).disparity;
  // Blocks around x = 2 and x = 1 are alike: |.|_1 = 0, weight 1. Around x = 4: columns 3 4 5 = 10 40 40 against
  // 10 10 10: 3 rows of 0 + 30 + 30 = 180, weight 1/181.
  const double wl = 1, wr = 1.0 / 181;
  EXPECT_NEAR(out.at(2, 1), (20 * wl + 8 * wr) / (wl + wr), 1e-5);
  // x = 3: columns 2 3 4 = 10 10 40 against 10 10 10: 90; against 10 40 40: 3 * (0 + 30 + 0) = 90: the plain mean.
  EXPECT_NEAR(out.at(3, 1), 14, 1e-5);
}

TEST(DisparityFilter, LeavesWhatHasNoNeighbourOnOneSideAndKeepsValues) {
  const ImageU8 grey(5, 2, 1, 100);
  ImageF d(5, 2, 1, 0.f);
  d.at(1, 0) = 5;
  d.at(3, 0) = 7;
  const ImageF out = fill_disparity(d, grey).disparity;
  EXPECT_EQ(out.at(0, 0), 0);
  EXPECT_EQ(out.at(4, 0), 0);
  EXPECT_EQ(out.at(1, 0), 5);
  EXPECT_EQ(out.at(3, 0), 7);
  EXPECT_NEAR(out.at(2, 0), 6, 1e-6);
  for (int x = 0; x < 5; ++x) EXPECT_EQ(out.at(x, 1), 0);  // rows do not help each other
}

TEST(DisparityFilter, FilledValuesAreNotUsedForFilling) {
  ImageU8 grey(6, 1, 1, 50);
  grey.at(2, 0) = 200;
  ImageF d(6, 1, 1, 0.f);
  d.at(0, 0) = 10;
  d.at(5, 0) = 20;
  const ImageF out = fill_disparity(d, grey).disparity;
  // Interpolation is between 10 and 20 in every gap, each by its own blocks: x = 4 differs from x = 0's block by less
  // than a chain of fills over x = 2 would have it.
  EXPECT_NEAR(out.at(4, 0), 15, 1e-5);
}

TEST(DisparityFilter, FlagsEveryGuessAndNothingElse) {
  Random random(3);
  ImageU8 grey(40, 30);
  for (auto& v : grey.data) v = static_cast<std::uint8_t>(random.below(256));
  ImageF d(40, 30, 1, 0.f);
  for (auto& v : d.data)
    if (random.below(3) == 0) v = static_cast<float>(1 + random.below(60));
  const FilledDisparity out = fill_disparity(d, grey);
  int guesses = 0;
  for (std::size_t i = 0; i < d.data.size(); ++i) {
    EXPECT_EQ(out.filled.data[i] != 0, d.data[i] == 0 && out.disparity.data[i] > 0);
    if (d.data[i] > 0) {
      EXPECT_EQ(out.disparity.data[i], d.data[i]);
    }
    guesses += out.filled.data[i] == 255;
  }
  EXPECT_GT(guesses, 600);
}

TEST(DisparityFilter, RefusesOtherSizes) { EXPECT_THROW(fill_disparity(ImageF(4, 4), ImageU8(4, 5)), Error); }

}  // namespace
}  // namespace periplus::vision
