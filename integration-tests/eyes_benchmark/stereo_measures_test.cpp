#include "integration-tests/eyes_benchmark/stereo_measures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "integration-tests/eyes_benchmark/stage.h"
#include "integration-tests/nbv_benchmark/depth_scene.h"

namespace periplus::eyes_benchmark {
namespace {

TEST(Spread, QuantilesOfAHundredNumbers) {
  std::vector<double> values;
  for (int i = 100; i >= 0; --i) values.push_back(i);
  const Spread s = spread(values);
  EXPECT_DOUBLE_EQ(s.mean, 50);
  EXPECT_DOUBLE_EQ(s.median, 50);
  EXPECT_DOUBLE_EQ(s.p95, 95);
  EXPECT_EQ(s.count, 101u);
  EXPECT_EQ(spread({}).count, 0u);
  EXPECT_EQ(spread({}).p95, 0);
}

// A plane across the optical axis, half of which is the object: z is one number, so each wrong disparity gives a known error.
struct Plane {
  StereoRig rig = robot_eyes();
  double z = 1.2;
  ImageF truth{640, 480, 1, 1.2f};
  ImageU8 object{640, 480};
  Plane() {
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 320; ++x) object.at(x, y) = 255;
  }
  ImageF disparities(double wrong) const { return ImageF(640, 480, 1, static_cast<float>(rig.disparity(z) + wrong)); }
};

TEST(StereoTally, EachMeasureIsItsClosedForm) {
  const Plane p;
  ImageF d = p.disparities(0.5);
  // Of the object's 480 rows: 24 without a match, 48 wrong by 1.5 px, 12 by -3 px. What is not the object counts nowhere.
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      if (y < 24) d.at(x, y) = 0;
      if (y >= 24 && y < 72) d.at(x, y) += 1;
      if (y >= 72 && y < 84) d.at(x, y) -= 3.5f;
      if (x >= 320) d.at(x, y) = 7;
    }
  ImageF surface(640, 480, 1, 1.2f), carved(640, 480, 1, static_cast<float>(p.z + kBehind - 1e-4));
  for (int x = 0; x < 640; ++x) {
    surface.at(x, 5) = 0;
    carved.at(x, 7) = static_cast<float>(p.z + kBehind + 1e-4);
  }
  StereoTally tally;
  tally.add(d, surface, carved, p.truth, p.object, p.rig);
  const StereoQuality q = tally.quality();
  EXPECT_EQ(q.pixels, 320u * 480);
  EXPECT_NEAR(q.valid, 456 / 480.0, 1e-12);
  EXPECT_NEAR(q.surface, 479 / 480.0, 1e-12);
  EXPECT_NEAR(q.bad_1, 60 / 456.0, 1e-12);
  EXPECT_NEAR(q.bad_2, 12 / 456.0, 1e-12);
  EXPECT_NEAR(q.sigma_px, std::sqrt((396 * 0.25 + 48 * 2.25) / 444), 1e-5);
  EXPECT_NEAR(q.behind, 1 / 480.0, 1e-12);
  const auto error = [&](double wrong) { return std::abs(p.rig.depth(p.rig.disparity(p.z) + wrong) - p.z); };
  EXPECT_NEAR(q.error.median, error(0.5), 1e-5);
  EXPECT_NEAR(q.error.p95, error(1.5), 1e-5);
  EXPECT_NEAR(q.error.mean, (396 * error(0.5) + 48 * error(1.5) + 12 * error(-3)) / 456, 1e-5);
  // A second view adds to the same counts.
  tally.add(p.disparities(0), {}, {}, p.truth, p.object, p.rig);
  EXPECT_NEAR(tally.quality().valid, (456 + 480) / 960.0, 1e-12);
  EXPECT_NEAR(tally.quality().bad_1, 60 / 936.0, 1e-12);
}

TEST(StereoTally, RefusesMapsOfDifferentSizes) {
  const Plane p;
  StereoTally tally;
  EXPECT_THROW(tally.add(ImageF(64, 48), {}, {}, p.truth, p.object, p.rig), Error);
  EXPECT_THROW(tally.add(p.disparities(0), ImageF(64, 48), {}, p.truth, p.object, p.rig), Error);
}

TEST(LeastWithin, OneLowPixelFillsItsSquareAndNoDepthIsLeast) {
  ImageF image(20, 15, 1, 2);
  image.at(10, 7) = 1;
  image.at(0, 14) = 0;
  const ImageF least = least_within(image, 5);
  for (int y = 0; y < 15; ++y)
    for (int x = 0; x < 20; ++x) {
      const bool low = std::abs(x - 10) <= 2 && std::abs(y - 7) <= 2, none = x <= 2 && y >= 12;
      EXPECT_EQ(least.at(x, y), none ? 0 : low ? 1 : 2) << x << " " << y;
    }
  EXPECT_EQ(least_within(image, 1).data, image.data);
  EXPECT_THROW(least_within(image, 4), Error);
}

// A flat wall, slanted by 30 degrees, whose depth is wrong as if it were slanted by 40: normals are off by 10.
TEST(NormalErrors, AWallWrongByTenDegrees) {
  const Pinhole camera = robot_eyes().camera;
  mesh::TriangleMesh wall = mesh::make_box({3, 0.1, 3}, 1);
  const auto depth_of = [&](double slant) {
    nbv_benchmark::DepthScene scene;
    scene.add(wall, make_pose({0, 0, 1.2}, rotation_from_yaw_pitch_roll(0, 0, 1.5707963 + slant)));
    return scene.render(Pose::Identity(), camera, 0);
  };
  mesh::TriangleMesh truth = wall;
  mesh::transform(truth, make_pose({0, 0, 1.2}, rotation_from_yaw_pitch_roll(0, 0, 1.5707963 + 30 / kDegrees)));
  const mesh::TriangleTree tree(truth);
  const ImageU8 object(640, 480, 1, 255);
  NormalErrors right, wrong;
  add_normal_errors(depth_of(30 / kDegrees), object, camera, Pose::Identity(), truth, tree, 20, right);
  add_normal_errors(depth_of(40 / kDegrees), object, camera, Pose::Identity(), truth, tree, 20, wrong);
  EXPECT_GT(right.angles.size(), 500u);
  EXPECT_EQ(right.tried, 32u * 24);
  EXPECT_NEAR(spread(right.angles).p95 * kDegrees, 0, 0.1);
  EXPECT_NEAR(spread(wrong.angles).median * kDegrees, 10, 0.1);
  EXPECT_NEAR(spread(wrong.angles).p95 * kDegrees, 10, 0.2);
  // Whichever way round the mesh's triangles are.
  mesh::flip(truth);
  NormalErrors flipped;
  add_normal_errors(depth_of(40 / kDegrees), object, camera, Pose::Identity(), truth, mesh::TriangleTree(truth), 20, flipped);
  EXPECT_NEAR(spread(flipped.angles).median * kDegrees, 10, 0.1);
}

TEST(DisparityQuality, CountsOnlyKnownTruthRightOfTheFirstColumn) {
  ImageF truth(100, 10, 1, 40), d(100, 10, 1, 40);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 100; ++x) {
      if (x < 20) d.at(x, y) = 0;             // left of the first column
      if (x >= 90) truth.at(x, y) = 0;        // truth unknown
      if (x >= 20 && x < 30) d.at(x, y) = 0;  // not covered
      if (x >= 30 && x < 36) d.at(x, y) = 41.5f;
      if (x >= 36 && x < 39) d.at(x, y) = 37.5f;
    }
  const DisparityQuality q = disparity_quality(d, truth, 20);
  EXPECT_EQ(q.pixels, 700u);
  EXPECT_NEAR(q.covered, 60 / 70.0, 1e-12);
  EXPECT_NEAR(q.bad_1, 9 / 60.0, 1e-12);
  EXPECT_NEAR(q.bad_2, 3 / 60.0, 1e-12);
  // Beside one that matches every other row, and nothing where the first is wrong by 1.5 px.
  ImageF other(100, 10, 1, 12);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 100; ++x)
      if (y % 2 || (x >= 30 && x < 36)) other.at(x, y) = 0;
  const DisparityQuality both = quality_where_both(d, other, truth, 20);
  EXPECT_EQ(both.pixels, 700u);
  EXPECT_NEAR(both.covered, 27 / 70.0, 1e-12);
  EXPECT_NEAR(both.bad_1, 3 / 54.0, 1e-12);
  EXPECT_NEAR(both.bad_2, 3 / 54.0, 1e-12);
}

}  // namespace
}  // namespace periplus::eyes_benchmark
