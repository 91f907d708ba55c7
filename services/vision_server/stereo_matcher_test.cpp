#include "services/vision_server/stereo_matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "integration-tests/harness/analytic_scene.h"

namespace periplus::vision {
namespace {

struct Pair {
  StereoRig rig;
  harness::AnalyticScene::Look left, right;
  ImageU8 left_grey, right_grey;
};

// A wall of a room, seen head on from `distance`.
Pair wall(double distance, double sigma) {
  const harness::AnalyticScene scene({}, {});
  Pair p;
  p.rig = {Pinhole::from_vertical_fov(320, 240, 0.436), 0.144};
  const Pose X_WL = look_at({3 - distance, 0, 1.4}, {3, 0, 1.4});
  p.left = scene.look(p.rig.camera, X_WL);
  p.right = scene.look(p.rig.camera, X_WL * Eigen::Translation3d(p.rig.baseline, 0, 0));
  p.left_grey = harness::to_grey(harness::with_sensor_noise(p.left.image, sigma, 1, 0, 1));
  p.right_grey = harness::to_grey(harness::with_sensor_noise(p.right.image, sigma, 1.03, 2, 2));
  return p;
}

TEST(StereoMatcher, APlaneHasTheDisparityOfItsDistance) {
  const Pair p = wall(1.2, 2);
  const double truth = p.rig.disparity(1.2);
  const DisparityPair d = match(p.left_grey, p.right_grey, {32, 64}, {});
  for (const ImageF* eye : {&d.left, &d.right}) {
    std::vector<double> errors;
    for (float v : eye->data)
      if (v > 0) errors.push_back(std::abs(v - truth));
    // The eyes share what is left after the disparity, some 20 % of the width less.
    ASSERT_GT(errors.size(), static_cast<std::size_t>(0.7 * 320 * 240));
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() / 2], 0.2);
    EXPECT_LT(errors[errors.size() * 95 / 100], 0.6);
  }
}

TEST(StereoMatcher, TheLeftStripIsMatchedAsWell) {
  const Pair p = wall(1.2, 0);
  const int seen_from = static_cast<int>(std::ceil(p.rig.disparity(1.2))) + 8;  // further left the right eye sees nothing
  const DisparityRange range{32, 96};
  ASSERT_LT(seen_from, range.least + range.count);  // the columns that OpenCV alone would leave out
  const DisparityPair d = match(p.left_grey, p.right_grey, range, {});
  int valid = 0, all = 0;
  for (int y = 20; y < 220; ++y)
    for (int x = seen_from; x < range.least + range.count; ++x, ++all) valid += d.left.at(x, y) > 0;
  EXPECT_GT(valid, 0.8 * all);
}

TEST(StereoMatcher, WhatOneEyeAloneSeesIsNotMatched) {
  const Pair p = wall(1.2, 2);
  const DisparityPair d = match(p.left_grey, p.right_grey, {32, 64}, {});
  const int unseen = static_cast<int>(p.rig.disparity(1.2)) - 8;
  int wrong = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < unseen; ++x) wrong += d.left.at(x, y) > 0;
  EXPECT_LT(wrong, 0.05 * 240 * unseen);
}

TEST(StereoMatcher, BothEyesMustAgree) {
  // A board before a wall hides a strip of it from the right eye: whatever is found there is wrong.
  scene::Solid board;
  board.size = {0.02, 0.12, 1};
  board.X_WS.translation() = Eigen::Vector3d(1, 0, 1.4);
  const harness::AnalyticScene scene({}, {board});
  const StereoRig rig{Pinhole::from_vertical_fov(320, 240, 0.436), 0.144};
  const Pose X_WL = look_at({0, 0.05, 1.4}, {1, 0.05, 1.4});
  const auto left = scene.look(rig.camera, X_WL);
  const auto right = scene.look(rig.camera, X_WL * Eigen::Translation3d(rig.baseline, 0, 0));
  const ImageU8 l = harness::to_grey(left.image), r = harness::to_grey(right.image);
  MatchSettings strict, loose;
  strict.uniqueness_percent = loose.uniqueness_percent = 0;
  strict.speckle_window = loose.speckle_window = 0;
  loose.left_right_px = 1000;
  const DisparityPair a = match(l, r, {16, 80}, strict), b = match(l, r, {16, 80}, loose);
  int hidden = 0, kept = 0, kept_loosely = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 80; x < 320; ++x) {
      if (left.object.at(x, y)) continue;
      const int there = static_cast<int>(std::lround(x - rig.disparity(left.depth.at(x, y))));
      if (there < 0 || !right.object.at(there, y)) continue;
      ++hidden;
      kept += a.left.at(x, y) > 0;
      kept_loosely += b.left.at(x, y) > 0;
    }
  ASSERT_GT(hidden, 2000);
  EXPECT_LT(kept, 0.15 * hidden);
  EXPECT_GT(kept_loosely, 2 * kept);
}

TEST(StereoMatcher, ResultsDoNotDependOnThreads) {
  const Pair p = wall(1.0, 2);
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  const DisparityPair one = match(p.left_grey, p.right_grey, {32, 64}, {});
  cv::setNumThreads(3);
  const DisparityPair three = match(p.left_grey, p.right_grey, {32, 64}, {});
  cv::setNumThreads(before);
  EXPECT_EQ(one.left.data, three.left.data);
  EXPECT_EQ(one.right.data, three.right.data);
}

TEST(StereoMatcher, RefusesWhatIsNoPair) {
  const ImageU8 a(64, 48), b(64, 47), rgb(64, 48, 3);
  EXPECT_THROW(match(a, b, {0, 16}, {}), Error);
  EXPECT_THROW(match(a, rgb, {0, 16}, {}), Error);
  EXPECT_THROW(match(a, a, {0, 15}, {}), Error);
  MatchSettings even;
  even.block = 4;
  EXPECT_THROW(match(a, a, {0, 16}, even), Error);
  EXPECT_THROW(match(ImageU8(4, 4), ImageU8(4, 4), {0, 16}, {}), Error);
  EXPECT_THROW(match(ImageU8(1024, 48), ImageU8(1024, 48), {2033, 16}, {}), Error);
}

// The greatest penalty that is allowed still matches; a greater one would wrap.
TEST(StereoMatcher, PenaltiesFitTheCosts) {
  const Pair p = wall(1.2, 2);
  const double truth = p.rig.disparity(1.2);
  for (const int block : {1, 5, 11, 21}) {
    MatchSettings s;
    s.block = block;
    s.penalty_2 = 20000 / (block * block);
    const DisparityPair d = match(p.left_grey, p.right_grey, {32, 64}, s);
    const auto right = std::count_if(d.left.data.begin(), d.left.data.end(), [&](float v) { return std::abs(v - truth) < 1; });
    EXPECT_GT(right, 0.65 * 320 * 240) << block;
    ++s.penalty_2;
    EXPECT_THROW(s.check(), Error) << block;
  }
}

}  // namespace
}  // namespace periplus::vision
