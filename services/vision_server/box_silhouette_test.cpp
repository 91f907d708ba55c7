#include "services/vision_server/box_silhouette.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "services/vision_server/disparity_filter.h"

namespace periplus::vision {
namespace {

const Pinhole kCamera = Pinhole::from_vertical_fov(160, 120, 0.6);

object_model::ObjectBox box_ahead(double z, double side) {
  object_model::ObjectBox box;
  box.X_WB.translation() = Eigen::Vector3d(0, 0, z);
  box.size.setConstant(side);
  return box;
}

TEST(BoxSilhouette, IsTheNearFaceOfABoxAhead) {
  const ImageU8 mask = box_silhouette(kCamera, Pose::Identity(), box_ahead(1, 0.2));
  const double half = kCamera.fx * 0.1 / 0.9;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const double off = std::max(std::abs(x - kCamera.cx), std::abs(y - kCamera.cy));
      if (off < half - 1.5) {
        EXPECT_EQ(mask.at(x, y), 255) << x << ' ' << y;
      } else if (off > half + 1.5) {
        EXPECT_EQ(mask.at(x, y), 0) << x << ' ' << y;
      }
    }
}

TEST(BoxSilhouette, GrowsAndCoversAllWhenTheCameraStandsInTheBox) {
  const auto count = [](const ImageU8& m) { return std::count(m.data.begin(), m.data.end(), 255); };
  EXPECT_GT(count(box_silhouette(kCamera, Pose::Identity(), box_ahead(1, 0.2), 0.05)),
            count(box_silhouette(kCamera, Pose::Identity(), box_ahead(1, 0.2))) * 3 / 2);
  EXPECT_EQ(count(box_silhouette(kCamera, Pose::Identity(), box_ahead(0.1, 0.2))), 160 * 120);
}

TEST(ValidShare, CountsOnlyTheSilhouetteThatBothEyesSee) {
  ImageU8 mask(20, 1);
  for (int x = 4; x < 16; ++x) mask.at(x, 0) = 255;
  ImageF d(20, 1);
  for (int x : {4, 5, 10, 11, 12, 19}) d.at(x, 0) = 3;
  EXPECT_EQ(hidden_from_right(d).data, ImageU8(20, 1).data);  // no steps
  EXPECT_DOUBLE_EQ(valid_share(d, mask, 0), 5.0 / 12);
  EXPECT_DOUBLE_EQ(valid_share(d, mask, 6), 3.0 / 10);  // x >= 6 alone
  EXPECT_DOUBLE_EQ(valid_share(d, ImageU8(20, 1), 0), 0);
  EXPECT_THROW(valid_share(d, ImageU8(19, 1), 0), Error);
}

// Disparity of a board of 0.2 m x 0.2 m at 1 m before a wall at 3 m, as the left eye measures it: the strip to the left
// of the board that the right eye cannot see is missing.
struct Board {
  StereoRig rig{kCamera, 0.1};
  ImageF disparity;
  int left, right, top, bottom;

  Board() : disparity(160, 120, 1, static_cast<float>(rig.disparity(3))) {
    const int half = static_cast<int>(kCamera.fx * 0.1), hidden = static_cast<int>(rig.disparity(1) - rig.disparity(3));
    left = 80 - half;
    right = 80 + half;
    top = 60 - half;
    bottom = 60 + half;
    for (int y = top; y < bottom; ++y)
      for (int x = left - hidden; x < right; ++x) disparity.at(x, y) = x < left ? 0 : static_cast<float>(rig.disparity(1));
  }
  std::optional<double> share(const scene::CollisionWorld* known = nullptr) const {
    return object_valid_share(disparity, fill_disparity(disparity, ImageU8(160, 120, 1, 100)).disparity, rig, Pose::Identity(),
                              box_ahead(1, 0.3), known);
  }
};

TEST(HiddenFromRight, AreGapsNoLongerThanTheStepUpAtTheirRightEnd) {
  ImageF d(40, 1);
  d.at(2, 0) = 10;   // 3..16: 14 px up to a step of 10, four of them blur
  d.at(17, 0) = 20;  // 18..25: a step down hides nothing
  d.at(26, 0) = 12;  // 27..37: 11 px, more than a step of 6 explains
  d.at(38, 0) = 18;  // 39: no end
  const ImageU8 hidden = hidden_from_right(d);
  for (int x = 0; x < 40; ++x) EXPECT_EQ(hidden.at(x, 0), x > 2 && x < 17 ? 255 : 0) << x;
}

TEST(ObjectValidShare, LeavesOutWhatTheRightEyeCannotSeeAndTheBackground) {
  const Board board;
  ASSERT_TRUE(board.share());
  EXPECT_DOUBLE_EQ(*board.share(), 1);
}

TEST(ObjectValidShare, CountsTheHolesOfTheObject) {
  Board board;
  // Every pixel of the board but its rim: as with a surface that has no texture.
  for (int y = board.top; y < board.bottom; ++y)
    for (int x = board.left + 4; x < board.right - 4; ++x) board.disparity.at(x, y) = 0;
  ASSERT_TRUE(board.share());
  EXPECT_NEAR(*board.share(), 8.0 / (board.right - board.left), 0.05);
  // Whereas the box's projection looks better matched.
  EXPECT_GT(valid_share(board.disparity, box_silhouette(kCamera, Pose::Identity(), box_ahead(1, 0.3)), 0), 0.4);
}

TEST(ObjectShares, TextureIsCountedOnTheSamePixels) {
  const Board board;
  ImageU8 textured(160, 120, 1, 255);
  for (int y = board.top; y < board.bottom; ++y)
    for (int x = board.left; x < 80; ++x) textured.at(x, y) = 0;  // its left half; the background does not matter
  const auto shares = object_shares(board.disparity, fill_disparity(board.disparity, ImageU8(160, 120, 1, 100)).disparity, textured, board.rig, Pose::Identity(),
                                    box_ahead(1, 0.3), nullptr);
  ASSERT_TRUE(shares);
  EXPECT_DOUBLE_EQ(shares->valid, *board.share());
  EXPECT_NEAR(shares->textured, 0.5, 0.06);
}

TEST(ObjectValidShare, KnownSolidsAreNotTheObject) {
  const Board board;
  scene::Scene known;
  scene::Solid solid;
  solid.size = {0.5, 0.5, 0.1};
  solid.X_WS.translation() = Eigen::Vector3d(0, 0, 1);
  known.solids = {solid};
  const scene::CollisionWorld world(known);
  EXPECT_FALSE(board.share(&world));
  EXPECT_TRUE(on_known_solid(&world, {0, 0, 0.945}));
  EXPECT_FALSE(on_known_solid(&world, {0, 0, 0.935}));
  EXPECT_FALSE(on_known_solid(nullptr, {0, 0, 1}));
}

}  // namespace
}  // namespace periplus::vision
