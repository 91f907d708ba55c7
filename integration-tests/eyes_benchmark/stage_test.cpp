#include "integration-tests/eyes_benchmark/stage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "integration-tests/eyes_benchmark/pictures.h"

namespace periplus::eyes_benchmark {
namespace {

constexpr double kRadius = 0.2;

Stage ball_stage() {
  mesh::TriangleMesh ball = mesh::make_sphere(2 * kRadius, 1);
  mesh::transform(ball, make_pose({0, 0, kTable + kRadius}, Eigen::Matrix3d::Identity()));
  return make_stage("ball", ball);
}

TEST(Stage, EyesAreTheRobots) {
  const StereoRig rig = robot_eyes();
  EXPECT_NEAR(rig.camera.fx, 1082.6, 0.1);
  EXPECT_DOUBLE_EQ(rig.baseline, 0.144);
}

TEST(Stage, SixViewsLookAtTheMiddleFromSixSides) {
  const Stage s = ball_stage();
  const auto views = six_views(s);
  ASSERT_EQ(views.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const Eigen::Vector3d eyes = views[i] * Eigen::Vector3d(0.072, 0, 0), in_eyes = views[i].inverse() * s.middle;
    EXPECT_NEAR((eyes - s.middle).norm(), kDistance, 1e-9);
    EXPECT_NEAR(in_eyes.x(), 0.072, 1e-9);
    EXPECT_NEAR(in_eyes.y(), 0, 1e-9);
    const Eigen::Vector3d next = views[(i + 1) % 6] * Eigen::Vector3d(0.072, 0, 0);
    const double turn = std::atan2(next.y(), next.x()) - std::atan2(eyes.y(), eyes.x());
    EXPECT_NEAR(std::remainder(turn - M_PI / 3, 2 * M_PI), 0, 1e-9);
  }
}

TEST(Stage, TurnedViewsStandOnACircle) {
  const Stage s = ball_stage();
  const auto views = turned_views(s, {0, 20, 60});
  ASSERT_EQ(views.size(), 3u);
  EXPECT_TRUE(views[0].isApprox(six_views(s)[0], 1e-12));
  for (const double degrees : {20, 60}) {
    const Pose& X = views[degrees == 20 ? 1 : 2];
    const Eigen::Vector3d from = views[0].translation() - s.middle, to = X.translation() - s.middle;
    EXPECT_NEAR(to.z(), from.z(), 1e-12);
    EXPECT_NEAR(std::remainder(std::atan2(to.y(), to.x()) - std::atan2(from.y(), from.x()) - degrees * M_PI / 180, 2 * M_PI), 0, 1e-9);
  }
}

// The middle of the picture shows the ball's nearest point; its outline is the tangent cone's.
TEST(Stage, TrueDepthAndMaskOfABall) {
  const Stage s = ball_stage();
  const Pinhole camera = robot_eyes().camera;
  const Pose X_WC = look_at(s.middle + Eigen::Vector3d(kDistance, 0, 0), s.middle);
  const EyeTruth t = true_eye(s, camera, X_WC);
  EXPECT_NEAR(t.depth.at(320, 240), kDistance - kRadius, 1e-3);
  EXPECT_EQ(t.object.at(320, 240), 255);
  EXPECT_EQ(t.object.at(2, 2), 0);
  EXPECT_EQ(t.depth.at(2, 2), kBackground);
  const double reach = camera.fx * std::tan(std::asin(kRadius / kDistance));
  int row = 0;
  for (int x = 0; x < 640; ++x) row += t.object.at(x, 240) != 0;
  EXPECT_NEAR(row, 2 * reach, 3);
}

// From around one sees all of the ball but what the table's neighbourhood hides from eyes at 1 to 1.4 m, and nothing of a smaller ball
// within it, which has a fifth of the surface.
TEST(Stage, VisibleSurfaceOfABallWithinABall) {
  mesh::TriangleMesh balls = ball_stage().mesh_W, within = mesh::make_sphere(kRadius, 1);
  mesh::transform(within, make_pose({0, 0, kTable + kRadius}, Eigen::Matrix3d::Identity()));
  const int first = static_cast<int>(balls.vertices.size());
  balls.vertices.insert(balls.vertices.end(), within.vertices.begin(), within.vertices.end());
  for (const Eigen::Vector3i& t : within.triangles) balls.triangles.push_back((t.array() + first).matrix());
  balls.corner_uv.clear();
  balls.corner_normals.clear();
  const Stage s = make_stage("balls", balls);
  const auto points = visible_surface(s, 5000, 1);
  double lowest = 10, highest = 0;
  for (const Eigen::Vector3d& p : points) {
    EXPECT_NEAR((p - s.middle).norm(), kRadius, 2e-3);
    lowest = std::min(lowest, p.z());
    highest = std::max(highest, p.z());
  }
  // A point at angle a above the horizon of the ball's middle is seen by eyes at height h: the plane tangent there lies below the eyes.
  const auto seen_from = [&](double height) {
    const double dz = height - s.middle.z(), r = std::sqrt(kDistance * kDistance - dz * dz);
    return std::atan2(dz, r) - std::acos(kRadius / kDistance);
  };
  EXPECT_NEAR(lowest, s.middle.z() + kRadius * std::sin(seen_from(1.0)), 0.01);
  EXPECT_NEAR(highest, s.middle.z() + kRadius, 0.005);
  EXPECT_NEAR(static_cast<double>(points.size()) / 4000, (1 - std::sin(seen_from(1.0))) / 2, 0.02);
}

TEST(Pictures, WeakTextureIsWeakAndTheSameForItsSeed) {
  const ImageU8 a = weak_texture(256, 128, 6);
  EXPECT_EQ(a.data, weak_texture(256, 128, 6).data);
  EXPECT_NE(a.data, weak_texture(256, 128, 7).data);
  const ImageU8 grey = to_grey(a);
  const auto [low, high] = std::minmax_element(grey.data.begin(), grey.data.end());
  EXPECT_NEAR(*high - *low, 32, 2);
}

}  // namespace
}  // namespace periplus::eyes_benchmark
