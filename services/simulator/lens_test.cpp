#include "services/simulator/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/error.h"

namespace periplus::simulator {
namespace {

const std::vector<double> kBarrel{-0.28, 0.09, 0.001, -0.0007, -0.01}, kPincushion{0.15, -0.04, -0.001, 0.002, 0};
const Pinhole kCamera = Pinhole::from_vertical_fov(160, 121, 0.75);

cv::Matx33d K_of(const Pinhole& c) { return {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1}; }

// A picture that tells where it was looked at: grey changes evenly with the direction.
double grey_of(double x, double y) { return 120 + 110 * x - 90 * y; }
ImageU8 picture_of(const Pinhole& camera) {
  ImageU8 picture(camera.width, camera.height, 3);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d d = camera.back_project(u, v, 1);
      for (int c = 0; c < 3; ++c) picture.at(u, v, c) = static_cast<std::uint8_t>(std::lround(grey_of(d.x(), d.y()) + 5 * c));
    }
  return picture;
}

TEST(Lens, PointsOfAChessboardLieWhereOpenCvSaysThatTheyDo) {
  std::vector<cv::Point3d> corners;
  for (int i = -4; i <= 4; ++i)
    for (int j = -3; j <= 3; ++j) corners.emplace_back(0.05 * i, 0.05 * j, 0.8 + 0.02 * i);
  for (const auto& distortion : {kBarrel, kPincushion}) {
    const Lens lens(kCamera, distortion);
    std::vector<cv::Point2d> seen;
    cv::projectPoints(corners, cv::Vec3d(), cv::Vec3d(), K_of(kCamera), distortion, seen);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d d = lens.distorted({corners[i].x / corners[i].z, corners[i].y / corners[i].z});
      EXPECT_NEAR(kCamera.fx * d.x() + kCamera.cx, seen[i].x, 1e-9);
      EXPECT_NEAR(kCamera.fy * d.y() + kCamera.cy, seen[i].y, 1e-9);
    }
  }
}

TEST(Lens, EachPixelShowsTheDirectionThatOpenCvSaysItDoes) {
  for (const auto& distortion : {kBarrel, kPincushion}) {
    const Lens lens(kCamera, distortion);
    const ImageU8 bent = lens.bend(picture_of(lens.drawn())), ideal = picture_of(kCamera);
    ASSERT_EQ(bent.width, kCamera.width);
    ASSERT_EQ(bent.height, kCamera.height);
    std::vector<cv::Point2d> pixels, directions;
    for (int v = 0; v < kCamera.height; ++v)
      for (int u = v % 7; u < kCamera.width; u += 7) pixels.emplace_back(u, v);
    cv::undistortPoints(pixels, directions, K_of(kCamera), distortion, cv::noArray(), cv::noArray(), cv::TermCriteria(cv::TermCriteria::COUNT, 100, 0));
    double moved = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const int u = static_cast<int>(pixels[i].x), v = static_cast<int>(pixels[i].y);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(bent.at(u, v, c), grey_of(directions[i].x, directions[i].y) + 5 * c, 1.01) << u << " " << v;
      moved = std::max(moved, std::abs(grey_of(directions[i].x, directions[i].y) - ideal.at(u, v)));
    }
    EXPECT_GT(moved, 3) << "a lens that hardly bends tests nothing";
  }
}

// What the vision server does with the picture and the calibration that goes with it.
TEST(Lens, RectifiedAgainItIsTheIdealPicture) {
  for (const auto& distortion : {kBarrel, kPincushion}) {
    const Lens lens(kCamera, distortion);
    ImageU8 bent = lens.bend(picture_of(lens.drawn()));
    cv::Mat x, y, straight;
    cv::initUndistortRectifyMap(K_of(kCamera), distortion, cv::noArray(), K_of(kCamera), {kCamera.width, kCamera.height}, CV_32FC1, x, y);
    cv::remap(cv::Mat(bent.height, bent.width, CV_8UC3, bent.data.data()), straight, x, y, cv::INTER_LINEAR);
    const ImageU8 ideal = picture_of(kCamera);
    int compared = 0;
    for (int v = 1; v + 1 < kCamera.height; ++v)
      for (int u = 1; u + 1 < kCamera.width; ++u) {
        const float at_x = x.at<float>(v, u), at_y = y.at<float>(v, u);
        if (at_x < 0 || at_y < 0 || at_x > static_cast<float>(kCamera.width - 1) || at_y > static_cast<float>(kCamera.height - 1)) continue;
        ++compared;
        EXPECT_LE(std::abs(straight.at<cv::Vec3b>(v, u)[0] - ideal.at(u, v)), 2) << u << " " << v;
      }
    EXPECT_GT(compared, kCamera.width * kCamera.height / 2);
  }
}

TEST(Lens, AnIdealOneChangesNothing) {
  for (const std::vector<double>& none : {std::vector<double>{}, std::vector<double>(5, 0.0)}) {
    const Lens lens(kCamera, none);
    EXPECT_TRUE(lens.ideal());
    EXPECT_EQ(lens.drawn().width, kCamera.width);
    EXPECT_EQ(lens.bend(picture_of(kCamera)).data, picture_of(kCamera).data);
  }
}

TEST(Lens, WhatNoLensDoesIsRefused) {
  EXPECT_THROW(Lens(kCamera, {0.1, 0.2}), Error);
  EXPECT_THROW(Lens(kCamera, {-5, 0, 0, 0, 0}), Error) << "the picture folds over";
  EXPECT_THROW(Lens(kCamera, {0, 0, 3, 0, 0}), Error);
  EXPECT_THROW(Lens(kCamera, {-0.3, 0, 0, 0, -1e6}), Error);
  EXPECT_THROW(Lens(kCamera, kBarrel).bend(ImageU8(3, 3)), Error);
}

}  // namespace
}  // namespace periplus::simulator
