#include "common/object_model/grid_projection.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace periplus::object_model {
namespace {

// Whatever point of a brick falls into the image falls into its rectangle, between its nearest and farthest depth.
TEST(GridProjection, ABricksRectangleHoldsAllOfItsPoints) {
  Random random(3);
  const Pinhole pinhole = Pinhole::from_vertical_fov(320, 240, 0.6);
  int within = 0, out_of_view = 0, behind = 0;
  for (int n = 0; n < 3000; ++n) {
    const voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({0, 0, 0}, Eigen::AngleAxisd(random.uniform(0, 3), Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix()),
                                                                {0.4, 0.4, 0.4}, 0.01);
    const Pose X_WC = look_at({random.uniform(-1.2, -0.1), random.uniform(-1, 1), random.uniform(-1, 1)}, {random.uniform(-0.5, 0.5), 0, 0});
    const GridProjection projection(pinhole, X_WC, g);
    const int b[3] = {static_cast<int>(random.below(5)), static_cast<int>(random.below(5)), static_cast<int>(random.below(5))};
    const BrickView view(projection, b[0], b[1], b[2]);
    behind += !view.in_front;
    out_of_view += view.out_of_view;
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d p_G(8 * b[0] + random.uniform(0, 8), 8 * b[1] + random.uniform(0, 8), 8 * b[2] + random.uniform(0, 8));
      const Eigen::Vector3d p_C = X_WC.inverse() * (g.X_WG * Eigen::Vector3d(p_G * g.voxel_size));
      EXPECT_GE(p_C.z(), view.near - 1e-9);
      EXPECT_LE(p_C.z(), view.far + 1e-9);
      const Eigen::Vector3f q(projection.camera.m[0][0] * static_cast<float>(p_G.x()) + projection.camera.m[0][1] * static_cast<float>(p_G.y()) + projection.camera.m[0][2] * static_cast<float>(p_G.z()) + projection.camera.m[0][3],
                              0, projection.camera.m[2][0] * static_cast<float>(p_G.x()) + projection.camera.m[2][1] * static_cast<float>(p_G.y()) + projection.camera.m[2][2] * static_cast<float>(p_G.z()) + projection.camera.m[2][3]);
      EXPECT_NEAR(q.z(), p_C.z(), 1e-5);
      if (p_C.z() < 0.05) continue;
      const Eigen::Vector2d uv = pinhole.project(p_C);
      EXPECT_NEAR(q.x() / q.z(), uv.x(), 0.02);
      if (uv.x() < 0 || uv.y() < 0 || uv.x() > 319 || uv.y() > 239) {
        EXPECT_FALSE(view.inside);
        continue;
      }
      EXPECT_FALSE(view.out_of_view);
      if (!view.in_front) continue;
      ++within;
      EXPECT_GE(uv.x(), view.x0);
      EXPECT_LE(uv.x(), view.x1);
      EXPECT_GE(uv.y(), view.y0);
      EXPECT_LE(uv.y(), view.y1);
    }
  }
  EXPECT_GT(within, 5000);
  EXPECT_GT(out_of_view, 100);
  EXPECT_GT(behind, 5);
}

}  // namespace
}  // namespace periplus::object_model
