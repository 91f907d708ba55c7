#include "common/object_model/feature_direction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "common/core/random.h"

namespace periplus::object_model {
namespace {

TEST(SurfaceDirection, LiesInTheSurfaceAndIsSeenAlongTheAngle) {
  Random random(2);
  const Pinhole camera = Pinhole::from_vertical_fov(640, 480, 0.436);
  int tried = 0;
  for (int i = 0; i < 300; ++i) {
    const Pose X_WC = look_at({random.uniform(-1, 1), random.uniform(1, 2), random.uniform(0.5, 1.5)}, {0, 0, 1});
    Feature f;
    f.u = static_cast<float>(random.uniform(20, 620));
    f.v = static_cast<float>(random.uniform(20, 460));
    f.angle = static_cast<float>(random.uniform(0, 2 * std::numbers::pi));
    f.p_W = X_WC * camera.back_project(f.u, f.v, 1.3);
    f.normal_W = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    if (std::abs(f.normal_W.dot((f.p_W - X_WC.translation()).normalized())) < 0.1) continue;  // the surface is seen as a line
    ++tried;
    const Eigen::Vector3d t = surface_direction(f, camera, X_WC);
    EXPECT_NEAR(t.norm(), 1, 1e-9);
    EXPECT_NEAR(t.dot(f.normal_W), 0, 1e-9);
    // A small step on the surface is a step along the angle in the image.
    const Eigen::Vector2d step = camera.project(X_WC.inverse() * Eigen::Vector3d(f.p_W + 1e-5 * t)) - camera.project(X_WC.inverse() * f.p_W);
    const double seen = std::atan2(step.y(), step.x());
    EXPECT_NEAR(std::remainder(seen - f.angle, 2 * std::numbers::pi), 0, 1e-3);
  }
  EXPECT_GT(tried, 200);
}

TEST(SurfaceDirection, NeedsANormal) {
  Feature f;
  EXPECT_TRUE(surface_direction(f, Pinhole::from_vertical_fov(64, 48, 0.4), Pose::Identity()).isZero());
}

// A spot on the surface keeps its direction from wherever it is seen: what lets observations be compared.
TEST(SurfaceDirection, DoesNotDependOnTheView) {
  const Pinhole camera = Pinhole::from_vertical_fov(640, 480, 0.436);
  const Eigen::Vector3d p(0, 0, 1), n(0, 1, 0), mark = Eigen::Vector3d(1, 0, 2).normalized();  // a stroke on a wall
  for (const Eigen::Vector3d& from : {Eigen::Vector3d(0, 1.2, 1), Eigen::Vector3d(0.7, 1, 1.4), Eigen::Vector3d(-0.6, 0.9, 0.6)}) {
    const Pose X_WC = look_at(from, {0.02, 0, 1.03});
    const Eigen::Vector2d at = camera.project(X_WC.inverse() * p), end = camera.project(X_WC.inverse() * Eigen::Vector3d(p + 1e-5 * mark));
    Feature f;
    f.u = static_cast<float>(at.x());
    f.v = static_cast<float>(at.y());
    f.angle = static_cast<float>(std::atan2(end.y() - at.y(), end.x() - at.x()));
    f.p_W = p;
    f.normal_W = n;
    EXPECT_NEAR((surface_direction(f, camera, X_WC) - mark).norm(), 0, 1e-3);
  }
}

}  // namespace
}  // namespace periplus::object_model
