#include "services/vision_server/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "integration-tests/harness/analytic_scene.h"
#include "services/vision_server/testing/opencv_threads.h"

namespace periplus::vision {
namespace {

struct Setting {
  StereoRig rig{Pinhole::from_vertical_fov(320, 240, 0.436), 0.144};
  Pose X_WC = look_at({1.1, 0.1, 1.3}, {0, 0, 1});
  object_model::ObjectBox box;
  harness::AnalyticScene scene;
  ImageU8 left, right;
  object_model::DepthMap depth;

  static std::vector<scene::Solid> ball() {
    scene::Solid s;
    s.shape = scene::Shape::sphere;
    s.size.setConstant(0.3);
    s.X_WS.translation() = Eigen::Vector3d(0, 0, 1);
    return {s};
  }
  Setting() : scene({}, ball()) {
    box.X_WB.translation() = Eigen::Vector3d(0, 0, 1);
    box.size.setConstant(0.4);
    const auto l = scene.look(rig.camera, X_WC);
    left = harness::to_grey(harness::with_sensor_noise(l.image, 1, 1, 0, 1));
    right = harness::to_grey(harness::with_sensor_noise(
        scene.look(rig.camera, X_WC * Eigen::Translation3d(rig.baseline, 0, 0)).image, 1, 1.03, 2, 2));
    depth = {rig.camera, X_WC, l.depth, l.depth, ImageF(320, 240, 1, 0.001f)};
  }
};

TEST(Features, LieOnTheSurfaceWithItsNormalAndSize) {
  const Setting s;
  const auto found = find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, nullptr, {});
  ASSERT_GE(found.size(), 15u);
  int with_normal = 0;
  for (const auto& f : found) {
    EXPECT_NEAR(s.scene.object_distance(f.p_W), 0, 0.01);  // a pixel at the rim is a centimetre
    const Eigen::Vector3d p_C = s.X_WC.inverse() * f.p_W;
    EXPECT_NEAR((s.rig.camera.project(p_C) - Eigen::Vector2d(f.u, f.v)).norm(), 0, 1e-4);
    EXPECT_NEAR(f.size_m, f.size * p_C.z() / s.rig.camera.fx, 1e-9);
    EXPECT_EQ(f.kind, object_model::DescriptorKind::root_sift);
    EXPECT_EQ(f.descriptor.size(), 128u);
    if (f.normal_W.isZero()) continue;
    ++with_normal;
    const Eigen::Vector3d radial = (f.p_W - Eigen::Vector3d(0, 0, 1)).normalized();
    EXPECT_GT(f.normal_W.dot(radial), 0.9);
  }
  EXPECT_GT(with_normal, static_cast<int>(found.size()) / 2);
}

TEST(Features, OnlyWhereThereIsDepthInTheBox) {
  Setting s;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 160; ++x) s.depth.depth.at(x, y) = 0;
  for (const auto& f : find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, nullptr, {})) EXPECT_GT(f.u, 159);
  s.box.X_WB.translation().y() = 2;
  EXPECT_TRUE(find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, nullptr, {}).empty());
}

TEST(Features, ThoseOfKnownSolidsAreLeftOut) {
  const Setting s;
  scene::Scene known;
  scene::Solid plate;
  plate.size = {0.4, 0.4, 0.1};
  plate.X_WS.translation() = Eigen::Vector3d(0, 0, 1.1);
  known.solids = {plate};
  const scene::CollisionWorld world(known);
  const auto all = find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, nullptr, {});
  const auto rest = find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, &world, {});
  EXPECT_LT(rest.size(), all.size());
  EXPECT_FALSE(rest.empty());
  for (const auto& f : rest) EXPECT_LT(f.p_W.z(), 1.0401);
}

TEST(Features, TheRightEyeHasToShowThem) {
  const Setting s;
  FeatureSettings unchecked;
  unchecked.selection.method = FeatureSelection::left_alone;
  const auto all = find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, nullptr, unchecked);
  EXPECT_LT(find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, nullptr, {}).size(), all.size());
  EXPECT_EQ(find_features(s.left, ImageU8(320, 240, 1, 90), s.rig, {&s.depth, 1}, {}, s.box, nullptr, {}).size(), 0u);
  EXPECT_EQ(find_features(s.left, ImageU8(320, 240, 1, 90), s.rig, {&s.depth, 1}, {}, s.box, nullptr, unchecked).size(), all.size());
}

TEST(Features, AreSpreadOverTheObjectAndAtMostAsManyAsAsked) {
  const Setting s;
  FeatureSettings few;
  few.most = 10;
  few.cell_px = 40;
  few.selection.method = FeatureSelection::left_alone;
  const auto found = find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, nullptr, few);
  ASSERT_EQ(found.size(), 10u);
  std::map<std::pair<int, int>, int> cells;
  for (const auto& f : found) ++cells[{static_cast<int>(f.v) / 40, static_cast<int>(f.u) / 40}];
  EXPECT_GE(cells.size(), 6u);
}

// Every second column of blocks is unmatched and filled with a guess; the truth tells how good places are.
TEST(Features, WhereTheDisparityIsAGuessBothEyesPlaceThem) {
  Setting s;
  FilledDisparity filled{ImageF(320, 240), ImageU8(320, 240)};
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const double d = s.rig.disparity(s.depth.depth.at(x, y));
      filled.disparity.at(x, y) = static_cast<float>(d);
      if (x / 16 % 2) continue;
      filled.disparity.at(x, y) = static_cast<float>(d + 0.6);  // 1.1 cm off
      filled.filled.at(x, y) = 255;
      s.depth.depth.at(x, y) = s.depth.depth_minimum.at(x, y) = 0;
    }
  FeatureSettings without;
  without.on_filled = false;
  const auto measured = find_features(s.left, s.right, s.rig, {&s.depth, 1}, filled, s.box, nullptr, without);
  const auto all = find_features(s.left, s.right, s.rig, {&s.depth, 1}, filled, s.box, nullptr, {});
  EXPECT_GT(all.size(), measured.size() + 5);
  std::vector<double> errors;
  for (const auto& f : all) {
    const int u = static_cast<int>(std::lround(f.u)), v = static_cast<int>(std::lround(f.v));
    if (filled.filled.at(u, v)) errors.push_back(std::abs(s.scene.object_distance(f.p_W)));
  }
  std::sort(errors.begin(), errors.end());
  ASSERT_GT(errors.size(), 5u);
  EXPECT_LT(errors[errors.size() / 2], 0.005);  // not the guess's centimetre
  without.on_filled = true;
  without.selection.method = FeatureSelection::left_alone;  // nobody confirms: no guesses
  for (const auto& f : find_features(s.left, s.right, s.rig, {&s.depth, 1}, filled, s.box, nullptr, without))
    EXPECT_EQ(filled.filled.at(static_cast<int>(std::lround(f.u)), static_cast<int>(std::lround(f.v))), 0);
}

TEST(Features, OfEveryKindLieOnTheSurface) {
  const Setting s;
  for (const DescriptorKind kind : {DescriptorKind::root_sift, DescriptorKind::akaze, DescriptorKind::orb})
    for (const FeatureSelection method : {FeatureSelection::descriptor_first, FeatureSelection::geometry_first}) {
      FeatureSettings settings;
      settings.detector.kind = kind;
      settings.selection.method = method;
      const auto found = find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, nullptr, settings);
      EXPECT_GE(found.size(), 5u) << to_string(kind) << static_cast<int>(method);
      for (const auto& f : found) {
        EXPECT_EQ(f.kind, kind);
        EXPECT_EQ(f.descriptor.size(), object_model::descriptor_octets(kind));
        EXPECT_NEAR(s.scene.object_distance(f.p_W), 0, 0.01);
      }
    }
}

TEST(Features, AreTheSameAgainWithAnyNumberOfThreads) {
  const Setting s;
  const auto with = [&](int threads) {
    const testing::OpenCvThreads set(threads);
    return find_features(s.left, s.right, s.rig, {&s.depth, 1}, {}, s.box, nullptr, {});
  };
  const auto a = with(1), b = with(4);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].u, b[i].u);
    EXPECT_EQ(a[i].descriptor, b[i].descriptor);
    EXPECT_EQ(a[i].p_W, b[i].p_W);
  }
}

}  // namespace
}  // namespace periplus::vision
