// Depth through bent lenses, from the simulator's picture to the perception: as good as through ideal ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "integration-tests/harness/analytic_scene.h"
#include "services/simulator/lens.h"
#include "services/vision_server/perceive.h"
#include "services/vision_server/rectification.h"

namespace periplus::harness {
namespace {

// A textured ball on a table, from 1.2 m.
struct Ball {
  scene::Scene known;
  object_model::ObjectBox box;
  StereoRig rig{Pinhole::from_vertical_fov(640, 480, 0.436332), 0.144};
  Pose X_WC = look_at({1.1, 0.3, 1.25}, {0, 0, 0.85}) * Eigen::Translation3d(-0.072, 0, 0);
  std::vector<scene::Solid> object{1};
  Ball() {
    scene::Solid table;
    table.size = {0.7, 0.7, 0.7};
    table.X_WS.translation() = Eigen::Vector3d(0, 0, 0.35);
    known.solids = {table};
    object[0].shape = scene::Shape::sphere;
    object[0].size.setConstant(0.3);
    object[0].X_WS.translation() = Eigen::Vector3d(0, 0, 0.85);
    box.X_WB.translation() = Eigen::Vector3d(0, 0, 0.9);
    box.size = {0.4, 0.4, 0.4};
  }
};

struct Quality {
  double share = 0;        // of the ball's pixels that have depth
  double median_m = 0, p95_m = 0;
};

Quality seen_through(const std::vector<double>& left_distortion, const std::vector<double>& right_distortion) {
  const Ball ball;
  const AnalyticScene scene(ball.known, ball.object);
  const simulator::Lens left(ball.rig.camera, left_distortion), right(ball.rig.camera, right_distortion);
  vision::CapturedView view;
  view.left = with_sensor_noise(left.bend(scene.look(left.drawn(), ball.X_WC).image), 2, 1, 0, 1);
  view.right = with_sensor_noise(right.bend(scene.look(right.drawn(), ball.X_WC * Eigen::Translation3d(ball.rig.baseline, 0, 0)).image), 2, 1.03, 2, 2);
  view.left_calibration = CameraCalibration::ideal(ball.rig.camera);
  view.right_calibration = CameraCalibration::ideal(ball.rig.camera, ball.rig.baseline);
  view.left_calibration.distortion = left.distortion();
  view.right_calibration.distortion = right.distortion();
  vision::RectificationMaps maps;
  const vision::RectifiedPair pair = vision::rectify(view, ball.X_WC, maps);
  const scene::CollisionWorld solids(ball.known);
  vision::PerceiveReport report;
  const object_model::Perception p = vision::perceive(pair, ball.box, {&ball.known, &solids}, {}, [] { return 0.0; }, report);
  const AnalyticScene::Look truth = scene.look(ball.rig.camera, ball.X_WC);
  std::vector<double> errors;
  double pixels = 0;
  for (std::size_t i = 0; i < truth.depth.data.size(); ++i) {
    if (truth.object.data[i] == 0) continue;
    ++pixels;
    if (const float z = p.depth.at(0).depth.data[i]; z > 0) errors.push_back(std::abs(z - truth.depth.data[i]));
  }
  std::sort(errors.begin(), errors.end());
  if (errors.empty()) return {};
  const auto at = [&](double share) { return errors[static_cast<std::size_t>(share * static_cast<double>(errors.size() - 1))]; };
  return {static_cast<double>(errors.size()) / pixels, at(0.5), at(0.95)};
}

TEST(DistortedEyes, DepthIsAsGoodAsThroughIdealLenses) {
  const Quality ideal = seen_through({}, {});
  // At the picture's corner they move a point by 12 pixels inwards and by 10 outwards.
  const Quality bent = seen_through({-0.22, 0.06, 0.001, -0.0007, 0}, {0.18, -0.04, -0.0008, 0.001, 0});
  std::printf("valid %.3f and %.3f, median %.2f and %.2f mm, p95 %.2f and %.2f mm: ideal and bent\n", ideal.share, bent.share, 1e3 * ideal.median_m,
              1e3 * bent.median_m, 1e3 * ideal.p95_m, 1e3 * bent.p95_m);
  EXPECT_GT(ideal.share, 0.8);
  EXPECT_GT(bent.share, ideal.share - 0.03);
  // Resampling twice takes away a little of the finest texture.
  EXPECT_LT(bent.median_m, 1.3 * ideal.median_m + 2e-4);
  EXPECT_LT(bent.p95_m, 1.3 * ideal.p95_m + 1e-3);
}

}  // namespace
}  // namespace periplus::harness
