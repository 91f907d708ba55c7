#include "services/vision_server/perceive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "integration-tests/harness/analytic_scene.h"
#include "services/vision_server/testing/opencv_threads.h"

namespace periplus::vision {
namespace {

// A textured ball of 0.3 m on a table in a room, seen by the robot's eyes from 1.2 m.
struct PerceptionSetting {
  scene::Scene known;
  std::vector<scene::Solid> object;
  object_model::ObjectBox box;
  StereoRig rig{Pinhole::from_vertical_fov(640, 480, 0.436332), 0.144};
  Pose X_WC;
  harness::AnalyticScene::Look truth;

  PerceptionSetting() {
    scene::Solid table;
    table.size = {0.7, 0.7, 0.7};
    table.X_WS.translation() = Eigen::Vector3d(0, 0, 0.35);
    known.solids = {table};
    scene::Solid ball;
    ball.shape = scene::Shape::sphere;
    ball.size.setConstant(0.3);
    ball.X_WS.translation() = Eigen::Vector3d(0, 0, 0.85);
    object = {ball};
    box.X_WB.translation() = Eigen::Vector3d(0, 0, 0.9);
    box.size = {0.4, 0.4, 0.4};
    X_WC = look_at({1.1, 0.3, 1.25}, {0, 0, 0.85}) * Eigen::Translation3d(-0.072, 0, 0);
  }
  RectifiedPair pair(bool plain = false) {
    harness::AnalyticScene scene(known, object);
    scene.plain_object = plain;
    truth = scene.look(rig.camera, X_WC);
    const auto right = scene.look(rig.camera, X_WC * Eigen::Translation3d(rig.baseline, 0, 0));
    RectifiedPair p;
    p.rig = rig;
    p.X_WC = X_WC;
    p.left = harness::with_sensor_noise(truth.image, 2, 1, 0, 1);
    p.right = harness::with_sensor_noise(right.image, 2, 1.03, 2, 2);
    p.left_grey = harness::to_grey(p.left);
    p.right_grey = harness::to_grey(p.right);
    return p;
  }
};

object_model::Perception see(const RectifiedPair& pair, const PerceptionSetting& s, PerceiveReport* report = nullptr) {
  PerceiveReport unused;
  PerceiveSettings settings;
  settings.depth.footprint_m = 0.01;  // pixels are looked at one by one here
  const scene::CollisionWorld solids(s.known);
  return perceive(pair, s.box, {&s.known, &solids}, settings, [] { return 0.0; }, report ? *report : unused);
}

TEST(Perceive, DepthOfATexturedBallIsGoodToMillimetres) {
  PerceptionSetting s;
  const RectifiedPair pair = s.pair();
  PerceiveReport report;
  const object_model::Perception p = see(pair, s, &report);
  ASSERT_EQ(p.depth.size(), 2u);
  EXPECT_GT(report.valid_share, 0.6);
  EXPECT_GT(report.valid_share_in_box, 0.8);
  EXPECT_GT(p.silhouette_valid_share, 0.8);
  EXPECT_GT(report.textured_share, 0.6);
  EXPECT_NEAR(report.noise, 2, 0.5);
  EXPECT_TRUE(p.depth[1].X_WC.isApprox(s.X_WC * Eigen::Translation3d(0.144, 0, 0), 1e-12));

  std::vector<double> errors;
  int object = 0, dangerous = 0;
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      if (!s.truth.object.at(x, y)) continue;
      ++object;
      const double z = s.truth.depth.at(x, y), found = p.depth[0].depth.at(x, y);
      // What may carve must not reach behind the surface.
      dangerous += p.depth[0].depth_minimum.at(x, y) > z + 0.005;
      if (found > 0) errors.push_back(std::abs(found - z));
    }
  std::sort(errors.begin(), errors.end());
  EXPECT_GT(static_cast<double>(errors.size()), 0.85 * object);
  EXPECT_LT(errors[errors.size() / 2], 0.003);
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.012);
  EXPECT_LT(dangerous, 0.001 * object);
  EXPECT_GT(p.features.size(), 30u);
}

TEST(Perceive, GuessedDisparitiesAreFlaggedAndMeasureNothing) {
  PerceptionSetting s;
  const RectifiedPair pair = s.pair();
  const object_model::Perception p = see(pair, s);
  ASSERT_EQ(p.disparity_filled.data.size(), p.disparity.data.size());
  int guesses = 0, matched = 0;
  for (std::size_t i = 0; i < p.disparity.data.size(); ++i) {
    if (p.disparity_filled.data[i] == 0) {
      matched += p.disparity.data[i] > 0;
      if (p.depth[0].depth_minimum.data[i] > 0) {
        EXPECT_GT(p.disparity.data[i], 0);
      }
      continue;
    }
    ++guesses;
    EXPECT_GT(p.disparity.data[i], 0);
    EXPECT_EQ(p.depth[0].depth.data[i], 0);
    EXPECT_EQ(p.depth[0].depth_minimum.data[i], 0);
    EXPECT_EQ(p.depth[0].depth_sigma.data[i], 0);
  }
  EXPECT_GT(guesses, 5000);
  EXPECT_GT(matched, 150000);
}

TEST(Perceive, TheWallBehindTheObjectIsMeasuredToo) {
  PerceptionSetting s;
  const RectifiedPair pair = s.pair();
  const object_model::Perception p = see(pair, s);
  int far = 0, measured = 0, right = 0;
  for (int y = 0; y < 480; ++y)
    for (int x = 120; x < 640; ++x)
      if (s.truth.depth.at(x, y) > 2) {
        ++far;
        const float z = p.depth[0].depth.at(x, y);
        measured += z > 0;
        right += z > 0 && std::abs(z - s.truth.depth.at(x, y)) < 0.1 * s.truth.depth.at(x, y);
      }
  ASSERT_GT(far, 20000);
  EXPECT_GT(measured, 0.6 * far);
  EXPECT_GT(right, 0.95 * measured);
}

TEST(Perceive, BothEyesTellTheSameSurface) {
  PerceptionSetting s;
  const RectifiedPair pair = s.pair();
  const object_model::Perception p = see(pair, s);
  harness::AnalyticScene scene(s.known, s.object);
  for (const object_model::DepthMap& eye : p.depth) {
    std::vector<double> errors;
    for (int y = 0; y < 480; y += 3)
      for (int x = 0; x < 640; x += 3) {
        const float z = eye.depth.at(x, y);
        if (z <= 0) continue;
        const Eigen::Vector3d p_W = eye.X_WC * eye.camera.back_project(x, y, z);
        if ((p_W - Eigen::Vector3d(0, 0, 0.85)).norm() < 0.17 && p_W.z() > 0.72)
          errors.push_back(std::abs(scene.object_distance(p_W)));
      }
    ASSERT_GT(errors.size(), 1000u);
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() / 2], 0.003);
  }
}

TEST(Perceive, APlainObjectIsNotMadeUp) {
  PerceptionSetting s;
  const RectifiedPair pair = s.pair(true);
  PerceiveReport report;
  const object_model::Perception p = see(pair, s, &report);
  int object = 0, found = 0;
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x)
      if (s.truth.object.at(x, y)) {
        ++object;
        found += p.depth[0].depth.at(x, y) > 0;
      }
  EXPECT_LT(found, 0.35 * object);
  EXPECT_LT(p.silhouette_valid_share, 0.8);
  EXPECT_LT(report.textured_share, 0.3);
}

// Matching that takes whatever it finds covers the plain ball too. Its texture still says that this is chance.
TEST(Perceive, APlainObjectIsCautiousHoweverMuchOfItWasMatched) {
  PerceptionSetting s;
  PerceiveSettings lax;
  lax.match.uniqueness_percent = 0;
  lax.match.left_right_px = 1000;
  lax.match.speckle_window = 0;
  const scene::CollisionWorld solids(s.known);
  const auto share = [&](double least_textured, bool plain) {
    lax.texture.least_share = least_textured;
    PerceiveReport report;
    return perceive(s.pair(plain), s.box, {&s.known, &solids}, lax, [] { return 0.0; }, report).silhouette_valid_share;
  };
  EXPECT_GT(share(0, true), 0.6);
  EXPECT_LT(share(0.5, true), 0.3);
  EXPECT_EQ(share(0.5, false), share(0, false));
}

TEST(Perceive, IsTheSameForAnyNumberOfThreads) {
  PerceptionSetting s;
  const RectifiedPair pair = s.pair();
  const auto with = [&](int threads) {
    const testing::OpenCvThreads set(threads);
    return see(pair, s);
  };
  const object_model::Perception one = with(1), four = with(4);
  for (int eye = 0; eye < 2; ++eye) {
    EXPECT_EQ(one.depth[eye].depth.data, four.depth[eye].depth.data);
    EXPECT_EQ(one.depth[eye].depth_minimum.data, four.depth[eye].depth_minimum.data);
  }
  EXPECT_EQ(one.disparity.data, four.disparity.data);
  EXPECT_EQ(one.disparity_filled.data, four.disparity_filled.data);
  EXPECT_EQ(one.silhouette_valid_share, four.silhouette_valid_share);
  ASSERT_EQ(one.features.size(), four.features.size());
  for (std::size_t i = 0; i < one.features.size(); ++i) {
    EXPECT_EQ(one.features[i].p_W, four.features[i].p_W);
    EXPECT_EQ(one.features[i].normal_W, four.features[i].normal_W);
    EXPECT_EQ(one.features[i].descriptor, four.features[i].descriptor);
  }
}

TEST(Perceive, ABlankEyeIsNamed) {
  PerceptionSetting s;
  RectifiedPair pair = s.pair();
  pair.right = harness::with_sensor_noise(ImageU8(640, 480, 3, 0), 2, 1, 20, 5);
  pair.right_grey = harness::to_grey(pair.right);
  try {
    see(pair, s);
    FAIL() << "a blank eye went unnoticed";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::vision_no_depth);
    EXPECT_NE(std::string(e.what()).find("right eye"), std::string::npos) << e.what();
  }
}

TEST(Perceive, EyesThatSeeDifferentThingsGiveNoDepth) {
  PerceptionSetting s;
  RectifiedPair pair = s.pair();
  // The right eye looks at other noise.
  const harness::AnalyticScene elsewhere({}, {});
  pair.right_grey = harness::to_grey(elsewhere.look(s.rig.camera, look_at({0, 0, 1.4}, {-3, 1, 1.4})).image);
  try {
    see(pair, s);
    FAIL() << "unrelated images were matched";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::vision_no_depth) << e.what();
  }
}

}  // namespace
}  // namespace periplus::vision
