#include "services/vision_server/depth.h"

#include <gtest/gtest.h>

#include <cmath>

namespace periplus::vision {
namespace {

const StereoRig kRig{Pinhole::from_vertical_fov(64, 48, 0.436332), 0.144};

// Near left half, far right half.
ImageF step(float near_disparity, float far_disparity) {
  ImageF d(64, 48, 1, far_disparity);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 32; ++x) d.at(x, y) = near_disparity;
  return d;
}

TEST(Depth, IsFocalLengthTimesBaselineByDisparityWithItsUncertainty) {
  DepthSettings s;
  s.disparity_sigma_px = 0.5;
  const auto map = make_depth(ImageF(64, 48, 1, 12.f), kRig, Pose::Identity(), s, 1);
  const double fB = kRig.camera.fx * 0.144, z = fB / 12;
  EXPECT_NEAR(map.depth.at(10, 10), z, 1e-6);
  EXPECT_NEAR(map.depth_minimum.at(10, 10), z, 1e-6);
  // Moving the disparity by a standard deviation moves the depth by one.
  EXPECT_NEAR(map.depth_sigma.at(10, 10), (fB / 11.5 - fB / 12.5) / 2, 1e-4);
}

// The far end of a hall, in fractions of a pixel of disparity: empty space up to there, and no depth.
TEST(Depth, WhatIsTooFarHasALeastDepthAlone) {
  const auto map = make_depth(ImageF(64, 48, 1, 1.f / 16), kRig, Pose::Identity(), {}, 1);
  EXPECT_EQ(map.depth.at(10, 10), 0);
  EXPECT_EQ(map.depth_sigma.at(10, 10), 0);
  EXPECT_EQ(map.depth_minimum.at(10, 10), 100);
  DepthSettings rough;
  rough.disparity_sigma_px = 9;
  EXPECT_EQ(make_depth(ImageF(64, 48, 1, 0.5f), kRig, Pose::Identity(), rough, 1).depth.at(10, 10), 0);  // 31 m, to 560
}

TEST(Depth, TheMinimumReachesHalfAFootprintOverAnEdge) {
  DepthSettings s;
  s.footprint_m = 0.05;  // at 1 m: 108.26 * 0.05 = 5.4 px, odd: 5
  ASSERT_EQ(footprint_px(kRig, s, 1), 5);
  const auto map = make_depth(step(14, 12), kRig, Pose::Identity(), s, 1);
  const float near = map.depth.at(5, 20), far = map.depth.at(60, 20);
  ASSERT_LT(near, far);
  EXPECT_EQ(map.depth_minimum.at(32, 20), near);
  EXPECT_EQ(map.depth_minimum.at(33, 20), near);
  EXPECT_EQ(map.depth_minimum.at(34, 20), far);
  EXPECT_EQ(map.depth.at(32, 20), far);  // two pixels of disparity are no flying pixels
}

TEST(Depth, TheLeastDepthHasTheLeastSigmaOfItsFootprint) {
  DepthSettings s;
  s.footprint_m = 0.05;  // 5 px
  s.flying_range_px = 100;
  ImageF d(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) d.at(x, y) = static_cast<float>(8 + (x * 7 + y * 13) % 11);
  const auto map = make_depth(d, kRig, Pose::Identity(), s, 1);
  for (int y = 2; y < 46; ++y)
    for (int x = 2; x < 62; ++x) {
      float least = 1e9f;
      for (int v = y - 2; v <= y + 2; ++v)
        for (int u = x - 2; u <= x + 2; ++u) least = std::min(least, map.depth_sigma.at(u, v));
      EXPECT_NEAR(depth_sigma(kRig, s, map.depth_minimum.at(x, y)), least, 1e-6);
    }
}

TEST(Depth, FlyingPixelsAreNoSurfaceButStillBoundFreeSpace) {
  const auto map = make_depth(step(20, 12), kRig, Pose::Identity(), {}, 1);
  for (int x : {30, 31, 32, 33}) {
    EXPECT_EQ(map.depth.at(x, 20), 0) << x;
    EXPECT_EQ(map.depth_sigma.at(x, 20), 0) << x;
    EXPECT_GT(map.depth_minimum.at(x, 20), 0) << x;
  }
  EXPECT_EQ(map.depth_minimum.at(32, 20), map.depth.at(5, 20));  // 3 px at 1 m
  EXPECT_GT(map.depth.at(29, 20), 0);
  EXPECT_GT(map.depth.at(34, 20), 0);
}

TEST(Depth, PixelsWithoutMatchClaimNothingAndDoNotSpoilTheirNeighbours) {
  ImageF d(64, 48, 1, 12.f);
  d.at(20, 20) = 0;
  const auto map = make_depth(d, kRig, Pose::Identity(), {}, 1);
  EXPECT_EQ(map.depth.at(20, 20), 0);
  EXPECT_EQ(map.depth_minimum.at(20, 20), 0);
  EXPECT_EQ(map.depth_sigma.at(20, 20), 0);
  EXPECT_GT(map.depth.at(21, 20), 0);
  EXPECT_EQ(map.depth_minimum.at(21, 20), map.depth.at(21, 20));
}

TEST(Depth, TheFootprintShrinksWithDistanceWithinItsBounds) {
  StereoRig rig{Pinhole::from_vertical_fov(640, 480, 0.436332), 0.144};
  DepthSettings voxel;
  voxel.footprint_m = 0.01;
  EXPECT_EQ(footprint_px(rig, voxel, 1.2), 9);
  EXPECT_GT(footprint_px(rig, voxel, 0.6), footprint_px(rig, voxel, 1.2));
  EXPECT_EQ(footprint_px(rig, voxel, 100), 3);
  EXPECT_EQ(footprint_px(rig, voxel, 0.01), 31);
}

TEST(Depth, RefusesOtherSizesAndSettings) {
  EXPECT_THROW(make_depth(ImageF(10, 10), kRig, Pose::Identity(), {}, 1), Error);
  DepthSettings even;
  even.flying_window_px = 4;
  EXPECT_THROW(make_depth(ImageF(64, 48), kRig, Pose::Identity(), even, 1), Error);
}

}  // namespace
}  // namespace periplus::vision
