#include "services/vision_server/calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "services/vision_server/testing/chessboard_pairs.h"
#include "services/vision_server/testing/drawn_board.h"

namespace periplus::vision {
namespace {

using testing::board_pose;
using testing::TrueCamera;

const Chessboard kMetric{9, 6, 0.03};

TrueCamera left_truth() {
  TrueCamera c;
  c.k1 = -0.26;
  c.k2 = 0.09;
  c.p1 = 0.0012;
  c.p2 = -0.0008;
  return c;
}

TrueCamera right_truth() {
  TrueCamera c = left_truth();
  c.fx = 548;
  c.fy = 547;
  c.cx = 314;
  c.k1 = -0.22;
  c.k2 = 0.05;
  return c;
}

// The right camera 12 cm to the right, turned by 1 degree inwards and a little about its axis.
const Pose kX_RL = make_pose({-0.12, 0.002, -0.001}, (Eigen::AngleAxisd(0.018, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(0.006, Eigen::Vector3d::UnitZ())).toRotationMatrix());

using Pairs = std::vector<std::pair<NamedView, NamedView>>;

// Corners where the true cameras see them, off by Gaussian noise.
Pairs seen_pairs(int number, double noise_px, double factor = 1, const Pose& X_RL = kX_RL) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 1);
  const auto seen = [&](const TrueCamera& c, const Pose& X_CB, const std::string& name) {
    NamedView v{name, {testing::true_corners(c, kMetric, X_CB), 3}};
    for (Eigen::Vector2d& p : v.board.corners) p += noise_px * Eigen::Vector2d(noise(random), noise(random));
    return v;
  };
  Pairs out;
  for (int n = 0; n < number; ++n) {
    const Pose X_LB = make_pose(board_pose(kMetric, n).translation() + Eigen::Vector3d(0.06, 0, 0.15 + 0.02 * (n / 12)), board_pose(kMetric, n).linear());
    out.emplace_back(seen(left_truth().scaled(factor), X_LB, "left" + std::to_string(n)), seen(right_truth().scaled(factor), X_RL * X_LB, "right" + std::to_string(n)));
  }
  return out;
}

PairFit fit(const Pairs& pairs, const CalibrationSettings& s = {}) { return calibrate_pair(pairs, 640, 480, kMetric, s); }

// The sentence with which `work` is refused.
std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    return e.what();
  }
  return "not refused";
}
::testing::AssertionResult says(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words)
    if (text.find(word) == std::string::npos) return ::testing::AssertionFailure() << "no '" << word << "' in: " << text;
  return ::testing::AssertionSuccess();
}

TEST(Calibration, RecoversKDistortionAndTheSecondCamera) {
  for (const double factor : {0.5, 1.0, 3.0}) {
    const PairFit f = calibrate_pair(seen_pairs(12, 0, factor), static_cast<int>(640 * factor), static_cast<int>(480 * factor), kMetric);
    const TrueCamera l = left_truth().scaled(factor), r = right_truth().scaled(factor);
    EXPECT_LT(f.rms_px, 1e-3) << factor;
    for (const auto& [camera, truth] : {std::pair{&f.left, &l}, {&f.right, &r}}) {
      EXPECT_NEAR(camera->K(0, 0), truth->fx, 0.02 * factor);
      EXPECT_NEAR(camera->K(1, 1), truth->fy, 0.02 * factor);
      EXPECT_NEAR(camera->K(0, 2), truth->cx, 0.02 * factor);
      EXPECT_NEAR(camera->K(1, 2), truth->cy, 0.02 * factor);
      EXPECT_NEAR(camera->distortion[0], truth->k1, 1e-3);
      EXPECT_NEAR(camera->distortion[1], truth->k2, 5e-3);
      EXPECT_NEAR(camera->distortion[2], truth->p1, 1e-4);
      EXPECT_NEAR(camera->distortion[3], truth->p2, 1e-4);
      EXPECT_EQ(camera->distortion[4], 0);
    }
    EXPECT_LT((f.T - kX_RL.translation()).norm(), 2e-5);
    EXPECT_LT((f.R - kX_RL.linear()).norm(), 1e-4);
    EXPECT_LT(f.row_px, 0.01 * factor);
  }
}

TEST(Calibration, NoiseOfATenthOfAPixelCostsLittleAndIsWhatRemains) {
  const PairFit f = fit(seen_pairs(12, 0.1));
  EXPECT_NEAR(f.rms_px, 0.1 * std::sqrt(2.0), 0.01);  // of two coordinates
  EXPECT_NEAR(f.left.K(0, 0), 540, 1.5);
  EXPECT_NEAR(f.baseline(), kX_RL.translation().norm(), 3e-4);
  EXPECT_GT(f.left.focal_sigma_px, 0.05);
  EXPECT_LT(f.left.focal_sigma_px, 2);
  EXPECT_NEAR(f.rms_px * f.rms_px, (std::pow(f.left.rms_px, 2) + std::pow(f.right.rms_px, 2)) / 2, 1e-4);  // OpenCV's own sum
}

TEST(Calibration, WhatIsRectifiedMakesARigAndItsDisparityIsFBByZ) {
  const PairFit f = fit(seen_pairs(12, 0));
  const CameraCalibration &l = f.left_rectified, &r = f.right_rectified;
  EXPECT_NEAR(-r.P(0, 3) / r.P(0, 0), f.baseline(), 1e-9);
  EXPECT_LT((l.P.leftCols<3>() - r.P.leftCols<3>()).norm(), 1e-9);
  // Both rectified frames have the direction of the baseline as their x axis.
  const Eigen::Vector3d right_in_left = -f.R.transpose() * f.T;
  EXPECT_LT((l.R * right_in_left - Eigen::Vector3d(f.baseline(), 0, 0)).norm(), 1e-9);
  EXPECT_LT((r.R * f.R * l.R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  const CameraCalibration u = calibrate_camera([] {
    std::vector<NamedView> views;
    for (const auto& p : seen_pairs(12, 0)) views.push_back(p.first);
    return views;
  }(), 640, 480, kMetric).undistorted();
  EXPECT_TRUE(u.R.isIdentity());
  // No pixel of the undistorted image lies outside the raw one, and no more is given away than that asks.
  double nearest = 1e9;
  for (const double v : {0.0, 240.0, 479.0})
    for (const double h : {0.0, 320.0, 639.0}) {
      const Eigen::Vector2d p = left_truth().project((h - u.P(0, 2)) / u.P(0, 0), (v - u.P(1, 2)) / u.P(1, 1));
      nearest = std::min({nearest, p.x(), p.y(), 639 - p.x(), 479 - p.y()});
    }
  EXPECT_GT(nearest, -1);
  EXPECT_LT(nearest, 3);
  EXPECT_EQ(u.P(0, 3), 0);
}

TEST(Calibration, TheOrderFromEitherEndIsTheSameBoard) {
  Pairs turned = seen_pairs(12, 0.05);
  for (std::size_t n = 0; n < turned.size(); n += 3) std::reverse(turned[n].second.board.corners.begin(), turned[n].second.board.corners.end());
  EXPECT_NEAR(fit(turned).rms_px, fit(seen_pairs(12, 0.05)).rms_px, 1e-4);
}

TEST(Calibration, TooFewOrTheSameAgainIsRefused) {
  EXPECT_TRUE(says(refusal([] { fit(seen_pairs(7, 0.05)); }), {"too few pairs", "7", "8"}));
  EXPECT_TRUE(says(refusal([] { fit({}); }), {"too few pairs"}));
  Pairs same = seen_pairs(7, 0);
  for (int i = 0; i < 4; ++i) {
    same.push_back(same[2]);
    same.back().first.name = "again" + std::to_string(i);
  }
  EXPECT_TRUE(says(refusal([&] { fit(same); }), {"too few pairs", "again0", "again3", "left2", "move the board"}));
  std::vector<NamedView> flat;  // seen square on only, at many places: the focal length may be anything
  for (int n = 0; n < 12; ++n) {
    const Pose X = make_pose({-0.2 + 0.02 * n, -0.1 + 0.01 * (n % 5), 0.6}, Eigen::Matrix3d::Identity());
    flat.push_back({"flat" + std::to_string(n), {testing::true_corners(left_truth(), kMetric, X), 3}});
    std::mt19937 random(static_cast<unsigned>(n));
    std::normal_distribution<double> noise(0, 0.2);
    for (Eigen::Vector2d& p : flat.back().board.corners) p += Eigen::Vector2d(noise(random), noise(random));
  }
  EXPECT_TRUE(says(refusal([&] { calibrate_camera(flat, 640, 480, kMetric); }), {"tilt"}));
}

TEST(Calibration, LeftAndRightExchangedIsToldFromTheGeometry) {
  Pairs all = seen_pairs(12, 0.1);
  for (auto& p : all) std::swap(p.first, p.second);
  EXPECT_TRUE(says(refusal([&] { fit(all); }), {"exchange the two folders"}));
  Pairs one = seen_pairs(12, 0.1);
  std::swap(one[4].first.board, one[4].second.board);
  const std::string why = refusal([&] { fit(one); });
  EXPECT_TRUE(says(why, {"left4 with right4", "exchange its two files"}));
  EXPECT_EQ(why.find("left5"), std::string::npos) << why;
  const Pose above = make_pose({0, -0.12, 0}, Eigen::Matrix3d::Identity());
  EXPECT_TRUE(says(refusal([&] { fit(seen_pairs(12, 0.1, 1, above)); }), {"side by side"}));
  Pairs same = seen_pairs(12, 0.1);
  for (auto& [l, r] : same) r.board = l.board;
  EXPECT_TRUE(says(refusal([&] { fit(same); }), {"from the same place"}));
}

TEST(Calibration, APairOfTwoMomentsIsNamed) {
  Pairs pairs = seen_pairs(12, 0.1);
  pairs[3].second.board = pairs[7].second.board;
  const std::string why = refusal([&] { fit(pairs); });
  EXPECT_TRUE(says(why, {"left3 with right3", "same moment"}));
  EXPECT_EQ(why.find("left7"), std::string::npos) << why;
}

TEST(Calibration, AnOutlierIsNamed) {
  Pairs pairs = seen_pairs(12, 0.1);
  for (std::size_t i = 0; i < 9; ++i) pairs[5].first.board.corners[i] += Eigen::Vector2d(6, -5);  // a row mistaken
  const std::string why = refusal([&] { fit(pairs); });
  EXPECT_TRUE(says(why, {"left5", "median"}));
  std::vector<NamedView> views;
  for (const auto& p : pairs) views.push_back(p.first);
  EXPECT_TRUE(says(refusal([&] { calibrate_camera(views, 640, 480, kMetric); }), {"left5", "median"}));
}

TEST(Calibration, NonsenseIsRefused) {
  Pairs pairs = seen_pairs(12, 0.1);
  pairs[2].second.board.corners[3].x() = std::nan("");
  EXPECT_TRUE(says(refusal([&] { fit(pairs); }), {"right2"}));
  pairs = seen_pairs(12, 0.1);
  pairs[2].first.board.corners.pop_back();
  EXPECT_TRUE(says(refusal([&] { fit(pairs); }), {"left2"}));
  EXPECT_NE(refusal([] { calibrate_pair(seen_pairs(12, 0.1), 640, 480, {9, 6, 0}); }), "not refused");
  EXPECT_NE(refusal([] { calibrate_pair(seen_pairs(12, 0.1), 0, 480, kMetric); }), "not refused");
  for (const CalibrationSettings& bad : {CalibrationSettings{.least_views = 2}, CalibrationSettings{.radial = 4}, CalibrationSettings{.outlier_px = std::nan("")}})
    EXPECT_NE(refusal([&] { fit(seen_pairs(12, 0.1), bad); }), "not refused");
  Pairs nowhere = seen_pairs(12, 0);
  for (auto& p : nowhere)
    for (Eigen::Vector2d& corner : p.first.board.corners) corner = {100, 100};
  EXPECT_NE(refusal([&] { fit(nowhere); }), "not refused");
}

// The chessboard pairs that OpenCV's documentation carries, lengths in squares. OpenCV's own sample, with corners refined in
// windows of 23 x 23 px, reaches a stereo RMS of 0.445 px and |T| = 3.338.
TEST(Calibration, RealPairsReachOpenCVsReference) {
  Pairs pairs;
  for (const auto& [left, right] : testing::chessboard_pairs()) {
    const BoardSearch l = find_board(left.grey, {9, 6, 1}), r = find_board(right.grey, {9, 6, 1});
    ASSERT_TRUE(l.view) << left.name << ": " << l.why;
    ASSERT_TRUE(r.view) << right.name << ": " << r.why;
    pairs.emplace_back(NamedView{left.name, *l.view}, NamedView{right.name, *r.view});
  }
  ASSERT_EQ(pairs.size(), 13u);
  for (const int radial : {2, 3}) {
    const PairFit f = calibrate_pair(pairs, 640, 480, {9, 6, 1}, {.radial = radial});
    EXPECT_LE(f.rms_px, 0.46);
    EXPECT_NEAR(f.baseline(), 3.338, 0.03338);
    EXPECT_NEAR(f.left.K(0, 0), 536, 5.36);
    EXPECT_NEAR(f.right.K(0, 0), 540, 5.4);
    EXPECT_LT(f.row_px, 0.46);
    ::testing::Test::RecordProperty("rms_px_radial_" + std::to_string(radial), std::to_string(f.rms_px));
    ::testing::Test::RecordProperty("baseline_radial_" + std::to_string(radial), std::to_string(f.baseline()));
  }
  for (auto& p : pairs) std::swap(p.first, p.second);
  EXPECT_TRUE(says(refusal([&] { calibrate_pair(pairs, 640, 480, {9, 6, 1}); }), {"exchange the two folders"}));
  for (auto& p : pairs) std::swap(p.first, p.second);
  std::swap(pairs[6].first.board, pairs[6].second.board);
  EXPECT_TRUE(says(refusal([&] { calibrate_pair(pairs, 640, 480, {9, 6, 1}); }), {"left07.jpg", "exchange its two files"}));
  std::swap(pairs[6].first.board, pairs[6].second.board);
  std::swap(pairs[1].second.board, pairs[2].second.board);
  EXPECT_TRUE(says(refusal([&] { calibrate_pair(pairs, 640, 480, {9, 6, 1}); }), {"left02.jpg", "left03.jpg", "same moment"}));
}

}  // namespace
}  // namespace periplus::vision
