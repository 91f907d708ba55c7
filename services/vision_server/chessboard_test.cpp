#include "services/vision_server/chessboard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/core/error.h"
#include "services/vision_server/testing/chessboard_pairs.h"
#include "services/vision_server/testing/drawn_board.h"

namespace periplus::vision {
namespace {

using testing::board_pose;
using testing::draw_board;
using testing::TrueCamera;

const Chessboard kBoard{9, 6, 1};

cv::Mat seen(ImageU8& image) { return {image.height, image.width, CV_8U, image.data.data()}; }

ImageU8 blurred(ImageU8 image, double across, double along) {
  cv::GaussianBlur(seen(image), seen(image), {}, across, along);
  return image;
}

// Mean distance from the true corners, which may be listed from the other end [px].
double distance(const BoardView& view, std::vector<Eigen::Vector2d> truth) {
  double least = 1e9;
  for (int end = 0; end < 2; ++end) {
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) sum += (view.corners[i] - truth[i]).norm();
    least = std::min(least, sum / static_cast<double>(truth.size()));
    std::reverse(truth.begin(), truth.end());
  }
  return least;
}

TEST(FindBoard, CornersAreFoundToAFractionOfAPixelAtAnyResolution) {
  TrueCamera camera;
  camera.k1 = -0.25;
  camera.k2 = 0.08;
  for (const double factor : {0.5, 1.0, 2.5})
    for (const int n : {0, 1, 5, 9}) {
      if (factor > 1 && n > 1) continue;
      const TrueCamera c = camera.scaled(factor);
      const BoardSearch s = find_board(draw_board(c, kBoard, board_pose(kBoard, n)), kBoard);
      ASSERT_TRUE(s.view) << factor << " " << n << ": " << s.why;
      EXPECT_LT(distance(*s.view, testing::true_corners(c, kBoard, board_pose(kBoard, n))), 0.1) << factor << " " << n;
      EXPECT_LT(s.view->edge_px, 3.2) << factor << " " << n;
    }
}

TEST(FindBoard, AnImageOfHardlyAnyContrastIsToldFromACoveredBoard) {
  ImageU8 image = draw_board({}, kBoard, board_pose(kBoard, 0));
  for (std::uint8_t& v : image.data) v = static_cast<std::uint8_t>(v / 24);  // as 12 bits in 16, read as 8
  const BoardSearch s = find_board(image, kBoard);
  ASSERT_FALSE(s.view);
  EXPECT_NE(s.why.find("hardly any contrast"), std::string::npos) << s.why;
}

TEST(FindBoard, BlurIsMeasuredAndRefusedInEitherDirection) {
  const ImageU8 sharp = draw_board({}, kBoard, board_pose(kBoard, 0));
  const double width = find_board(sharp, kBoard).view->edge_px;
  // A Gaussian's edge rises from 10 to 90 % within 2.56 standard deviations.
  BoardLimits any;
  any.edge_px = 100;
  const auto measured = find_board(blurred(sharp, 3, 3), kBoard, any);
  ASSERT_TRUE(measured.view);
  EXPECT_NEAR(measured.view->edge_px, 2.56 * 3, 1.2);
  EXPECT_LT(width, 3);
  for (const auto& [across, along] : {std::pair{2.5, 2.5}, {3.0, 0.1}, {0.1, 3.0}, {6.0, 6.0}}) {
    const BoardSearch s = find_board(blurred(sharp, across, along), kBoard);
    EXPECT_FALSE(s.view);
    EXPECT_NE(s.why.find("blurred"), std::string::npos) << across << " " << along << ": " << s.why;
  }
  EXPECT_TRUE(find_board(blurred(sharp, 0.8, 0.8), kBoard).view);
}

TEST(FindBoard, ABoardOnlyPartlySeenIsNoBoard) {
  const ImageU8 whole = draw_board({}, kBoard, board_pose(kBoard, 0));
  ImageU8 below = whole, right = whole, middle = whole;
  seen(below)(cv::Rect(0, 300, 640, 180)).setTo(100);
  seen(right)(cv::Rect(400, 0, 240, 480)).setTo(100);
  cv::circle(seen(middle), {330, 230}, 40, 128, cv::FILLED);
  for (const ImageU8* image : {&below, &right}) {
    const BoardSearch s = find_board(*image, kBoard);
    EXPECT_FALSE(s.view);
    EXPECT_NE(s.why.find("partly seen"), std::string::npos) << s.why;
  }
  // Of a board covered in its middle no large piece may be left: refused all the same.
  const BoardSearch s = find_board(middle, kBoard);
  EXPECT_FALSE(s.view);
  EXPECT_NE(s.why.find("cover"), std::string::npos) << s.why;
}

TEST(FindBoard, AnotherBoardsNumberIsToldFromTheImage) {
  const ImageU8 image = draw_board({}, kBoard, board_pose(kBoard, 1));
  for (const Chessboard& less : {Chessboard{8, 6, 1}, Chessboard{9, 5, 1}, Chessboard{7, 4, 1}}) {
    const BoardSearch s = find_board(image, less);
    EXPECT_FALSE(s.view) << less.columns;
    EXPECT_NE(s.why.find("own number"), std::string::npos) << s.why;
  }
  for (const Chessboard& more : {Chessboard{10, 6, 1}, Chessboard{9, 7, 1}, Chessboard{12, 9, 1}}) EXPECT_FALSE(find_board(image, more).view) << more.columns;
  // Columns and rows exchanged are the same board.
  EXPECT_TRUE(find_board(image, {6, 9, 1}).view);
}

TEST(FindBoard, APartOfARealBoardIsNotTakenForASmallerOne) {
  for (const auto& [left, right] : testing::chessboard_pairs())
    for (const auto* image : {&left, &right}) {
      const BoardSearch s = find_board(image->grey, {8, 6, 1});
      EXPECT_FALSE(s.view) << image->name;
      EXPECT_FALSE(find_board(image->grey, {10, 6, 1}).view) << image->name;
    }
}

// The search for pieces may go on beyond the board's rim, where a row of corners seems to follow.
TEST(FindBoard, ARealBoardCutByThePictureIsNotSaidToBeAnother) {
  for (const char* name : {"left04.jpg", "left05.jpg"}) {
    const testing::NamedImage whole = testing::chessboard_image(name);
    ImageU8 cut(380, whole.grey.height);
    for (int y = 0; y < cut.height; ++y)
      for (int x = 0; x < cut.width; ++x) cut.at(x, y) = whole.grey.at(x + 180, y);
    const BoardSearch s = find_board(cut, kBoard);
    EXPECT_FALSE(s.view) << name;
    EXPECT_EQ(s.why.find("own number"), std::string::npos) << name << ": " << s.why;
    EXPECT_NE(s.why.find("cut by the picture's edge"), std::string::npos) << name << ": " << s.why;
  }
  // Squares counted in place of corners.
  const BoardSearch s = find_board(testing::chessboard_image("left02.jpg").grey, {10, 7, 1});
  EXPECT_NE(s.why.find("where four squares meet"), std::string::npos) << s.why;
}

TEST(FindBoard, NothingIsFoundWhereNothingIs) {
  ImageU8 noise(320, 240);
  std::uint32_t state = 1;
  for (auto& v : noise.data) v = static_cast<std::uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
  for (const ImageU8& image : {ImageU8(640, 480, 1, 200), ImageU8(1, 1, 1, 0), ImageU8(8192, 1, 1, 0), noise}) {
    const BoardSearch s = find_board(image, kBoard);
    EXPECT_FALSE(s.view);
    EXPECT_FALSE(s.why.empty());
  }
}

TEST(FindBoard, ABoardThatCannotBeIsRefused) {
  for (const Chessboard& bad : {Chessboard{2, 6, 1}, Chessboard{9, 51, 1}, Chessboard{-1, 6, 1}, Chessboard{9, 6, 0}, Chessboard{9, 6, -1}, Chessboard{9, 6, std::nan("")}, Chessboard{9, 6, INFINITY}})
    EXPECT_THROW(find_board(ImageU8(64, 64), bad), Error);
}

}  // namespace
}  // namespace periplus::vision
