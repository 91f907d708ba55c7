#include "integration-tests/eyes_benchmark/feature_measures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "integration-tests/eyes_benchmark/stage.h"

namespace periplus::eyes_benchmark {
namespace {

using object_model::Feature;

Feature of_size(double size_m) {
  Feature f;
  f.size_m = size_m;
  return f;
}

TEST(FeatureMeasures, TruePlacesLieOnTheMesh) {
  mesh::TriangleMesh ball = mesh::make_sphere(0.4, 1);
  const mesh::TriangleTree tree(ball);
  const Pinhole camera = robot_eyes().camera;
  const Pose X_WC = look_at({1.2, 0, 0}, {0, 0, 0});
  Feature middle, beside;
  middle.u = static_cast<float>(camera.cx);
  middle.v = static_cast<float>(camera.cy);
  beside.u = beside.v = 2;
  const auto places = true_places(std::vector<Feature>{middle, beside}, camera, X_WC, tree);
  EXPECT_NEAR((places[0] - Eigen::Vector3d(0.2, 0, 0)).norm(), 0, 1e-3);
  EXPECT_FALSE(places[1].allFinite());
}

// First view: spots 0, 1, 2, and one that misses the mesh. Second: spot 0, spot 1 at twice the size, a spot of its own, a miss.
TEST(FeatureMeasures, PrecisionAndRecallByHand) {
  const double nan = std::nan("");
  const std::vector<Feature> a{of_size(0.01), of_size(0.01), of_size(0.01), of_size(0.01)}, b{of_size(0.011), of_size(0.02), of_size(0.01), of_size(0.01)};
  const std::vector<Eigen::Vector3d> true_a{{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {nan, nan, nan}}, true_b{{0, 0.004, 0}, {0.1, 0, 0}, {0.3, 0, 0}, {nan, nan, nan}};
  const std::vector<object_model::FeatureMatch> matches{{0, 0, 0.1}, {2, 2, 0.2}, {3, 3, 0.3}};
  const MatchQuality q = match_quality(a, true_a, b, true_b, matches);
  EXPECT_EQ(q.matches, 3u);
  EXPECT_EQ(q.right, 1u);
  EXPECT_EQ(q.possible, 1u);
  EXPECT_NEAR(q.precision(), 1 / 3.0, 1e-12);
  EXPECT_EQ(q.recall(), 1);
  EXPECT_EQ(MatchQuality{}.precision(), 0);
  EXPECT_THROW(match_quality(a, {}, b, true_b, matches), Error);
}

TEST(FeatureMeasures, LandmarksOfOneSpotArePure) {
  std::vector<object_model::SeenLandmark> landmarks(4);
  landmarks[0].seen = {{0, 0}};
  landmarks[1].seen = {{0, 1}, {1, 0}};
  landmarks[2].seen = {{0, 2}, {1, 1}, {2, 0}};
  landmarks[3].seen = {{1, 2}, {1, 3}};  // two directions of one view
  const std::vector<std::vector<Eigen::Vector3d>> truth{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{1, 0.004, 0}, {2, 0, 0}, {3, 0, 0}, {3, 0, 0}}, {{2, 0.006, 0}}};
  const LandmarkQuality q = landmark_quality(landmarks, truth);
  EXPECT_EQ(q.landmarks, 4u);
  EXPECT_EQ(q.joined, 2u);
  EXPECT_EQ(q.pure, 1u);
  EXPECT_EQ(q.observations, 5u);
  EXPECT_EQ(q.purity(), 0.5);
}

}  // namespace
}  // namespace periplus::eyes_benchmark
