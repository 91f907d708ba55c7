#include "integration-tests/harness/analytic_scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace periplus::harness {
namespace {

scene::Solid solid(scene::Shape shape, const Eigen::Vector3d& size, const Eigen::Vector3d& p) {
  scene::Solid s;
  s.shape = shape;
  s.size = size;
  s.X_WS.translation() = p;
  return s;
}

TEST(AnalyticScene, RaysHitWhatStandsInTheirWay) {
  const AnalyticScene scene({}, {solid(scene::Shape::sphere, {1, 1, 1}, {2, 0, 1}),
                                 solid(scene::Shape::box, {1, 1, 1}, {0, 2, 1}),
                                 solid(scene::Shape::cylinder, {1, 1, 1}, {-2, 0, 1})});
  const Eigen::Vector3d o(0, 0, 1);
  EXPECT_NEAR(scene.cast(o, {1, 0, 0}).t, 1.5, 1e-12);
  EXPECT_NEAR(scene.cast(o, {0, 1, 0}).t, 1.5, 1e-12);
  EXPECT_NEAR(scene.cast(o, {-2, 0, 0}).t, 0.75, 1e-12);
  EXPECT_NEAR(scene.cast(o, {0, -1, 0}).t, 3, 1e-12);  // the wall of a room of 6 m
  EXPECT_NEAR(scene.cast(o, {0, 0, -1}).t, 1, 1e-12);  // the floor
  EXPECT_NEAR((scene.cast(o, {1, 0, 0}).normal_W - Eigen::Vector3d(-1, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((scene.cast({-2, 0, 2.5}, {0, 0, -1}).normal_W - Eigen::Vector3d(0, 0, 1)).norm(), 0, 1e-12);
  EXPECT_FALSE(scene.is_object(scene.cast(o, {0, -1, 0})));
  EXPECT_TRUE(scene.is_object(scene.cast(o, {0, 1, 0})));
}

TEST(AnalyticScene, EveryHitLiesOnTheSurface) {
  const AnalyticScene scene({}, {solid(scene::Shape::sphere, {0.4, 0.4, 0.4}, {1.5, 0, 1}),
                                 solid(scene::Shape::box, {0.2, 0.5, 0.3}, {1.5, 0.4, 1}),
                                 solid(scene::Shape::cylinder, {0.3, 0.3, 0.5}, {1.5, -0.4, 1})});
  const Pinhole camera = Pinhole::from_vertical_fov(80, 60, 0.8);
  const Pose X_WC = look_at({0, 0, 1.3}, {1.5, 0, 1});
  const auto look = scene.look(camera, X_WC);
  int seen = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x)
      if (look.object.at(x, y)) {
        ++seen;
        EXPECT_NEAR(scene.object_distance(X_WC * camera.back_project(x, y, look.depth.at(x, y))), 0, 1e-6);
      }
  EXPECT_GT(seen, 200);
}

TEST(AnalyticScene, TheTextureIsThatOfThePointWhateverTheEye) {
  const AnalyticScene scene({}, {});
  const StereoRig rig{Pinhole::from_vertical_fov(64, 48, 0.6), 0.1};
  const Pose X_WL = look_at({0, 0, 1}, {3, 0, 1}), X_WR = X_WL * Eigen::Translation3d(rig.baseline, 0, 0);
  const auto left = scene.look(rig.camera, X_WL), right = scene.look(rig.camera, X_WR);
  // The wall at 3 m: disparity is the same everywhere; where it is nearly whole, pixels must agree.
  const double d = rig.disparity(3);
  const int shift = static_cast<int>(std::lround(d));
  double difference = 0, unshifted = 0;
  int count = 0;
  for (int y = 20; y < 28; ++y)
    for (int x = 20; x < 50; ++x, ++count) {
      difference += std::abs(left.image.at(x, y) - right.image.at(x - shift, y));
      unshifted += std::abs(left.image.at(x, y) - right.image.at(x, y));
    }
  EXPECT_LT(difference, 0.7 * unshifted);
}

TEST(SensorNoise, HasTheAskedStrengthAndIsSeeded) {
  const ImageU8 grey(100, 100, 1, 100);
  const ImageU8 a = with_sensor_noise(grey, 2, 1.03, 2, 7), b = with_sensor_noise(grey, 2, 1.03, 2, 7);
  EXPECT_EQ(a.data, b.data);
  EXPECT_NE(a.data, with_sensor_noise(grey, 2, 1.03, 2, 8).data);
  double sum = 0, squares = 0;
  for (auto v : a.data) sum += v, squares += static_cast<double>(v) * v;
  EXPECT_NEAR(sum / 1e4, 105, 0.15);
  EXPECT_NEAR(std::sqrt(squares / 1e4 - sum / 1e4 * sum / 1e4), 2, 0.2);
}

}  // namespace
}  // namespace periplus::harness
