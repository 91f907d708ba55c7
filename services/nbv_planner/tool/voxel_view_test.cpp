#include "services/nbv_planner/tool/voxel_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "common/mesh/triangle_mesh.h"
#include "common/scene/mesh_solid.h"
#include "common/voxel/visibility.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

int pixels_of(const VoxelView& view, voxel::VoxelState state) {
  int count = 0;
  for (int v = 0; v < view.rgba.height; ++v)
    for (int u = 0; u < view.rgba.width; ++u) {
      if (view.rgba.at(u, v, 3) == 0) continue;
      const int r = view.rgba.at(u, v, 0), g = view.rgba.at(u, v, 1), b = view.rgba.at(u, v, 2);
      const auto shown = g > r * 1.3 && g > b * 1.3 ? voxel::VoxelState::unknown : b > r ? voxel::VoxelState::known : voxel::VoxelState::environment;
      count += shown == state;
    }
  return count;
}

TEST(VoxelView, ShowsAsManyPixelsOfEachKindAsTheVisibilityKernelCounts) {
  Random random(5);
  for (int i = 0; i < 4; ++i) {
    const Situation s = testing::around_the_origin(14, [&](int x, int y, int z) {
      const double r = std::hypot(x - 6.5, y - 6.5, z - 6.5);
      if (r > 6.5 + std::sin(x * 1.3 + y)) return voxel::VoxelState::empty;
      return random.uniform() < 0.4 ? voxel::VoxelState::unknown : random.uniform() < 0.7 ? voxel::VoxelState::known : voxel::VoxelState::environment;
    });
    const Pose X = look_at({1.0 * std::cos(i * 1.7), 1.0 * std::sin(i * 1.7), 1.0 + 0.15 * i}, {0.02, 0.01, 1.1});
    const Pinhole camera = Pinhole::from_vertical_fov(320, 240, 0.6);
    const voxel::VisibilityResult truth = voxel::VisibilityScene(*s.grid).evaluate(X, camera);
    const VoxelView view = draw_voxels(*s.grid, {}, Projection::camera(X, camera));
    ASSERT_GT(truth.unknown_pixels, 1000u);
    // Pixels whose centre lies on an edge may go either way.
    EXPECT_NEAR(pixels_of(view, voxel::VoxelState::unknown), static_cast<double>(truth.unknown_pixels), 0.002 * static_cast<double>(truth.unknown_pixels) + 2);
    EXPECT_NEAR(pixels_of(view, voxel::VoxelState::known), static_cast<double>(truth.known_pixels), 0.002 * static_cast<double>(truth.known_pixels) + 2);
  }
}

TEST(VoxelView, ParallelLinesKeepTheirScale) {
  const Eigen::Vector3d middle(0.3, -0.2, 1);
  for (const Projection& p : {Projection::parallel(0.7, 0.4, middle, 100, 300, 200), Projection::above(middle, 100, 300, 200)}) {
    EXPECT_TRUE(p.point(middle).isApprox(Eigen::Vector2d(150, 100), 1e-9));
    EXPECT_TRUE(p.finer(2).point(middle).isApprox(Eigen::Vector2d(300, 200), 1e-9));
    const Eigen::Vector3d up = p.to_viewer(middle);
    EXPECT_GT(p(middle + 0.1 * up).z(), p(middle).z());
    EXPECT_TRUE(p.point(middle + 0.1 * up).isApprox(p.point(middle), 1e-6));
  }
  const Projection above = Projection::above(middle, 100, 300, 200);
  EXPECT_TRUE(above.point(middle + Eigen::Vector3d(0.5, 0.25, 0.7)).isApprox(Eigen::Vector2d(200, 75), 1e-9));
  const Projection side = Projection::parallel(0, 0, middle, 100, 300, 200);  // from +x: +y to the right, up is up
  EXPECT_TRUE(side.point(middle + Eigen::Vector3d(3, 0.5, 0.25)).isApprox(Eigen::Vector2d(200, 75), 1e-9));
}

TEST(VoxelView, ASolidBeforeTheObjectIsGlassAndOneBehindItIsNot) {
  scene::Scene scene;
  scene.solids.push_back(testing::box({0.6, 0, 1.1}, {0.1, 0.1, 0.1}));
  const Situation s = testing::around_the_origin(15, [](int, int, int) { return voxel::VoxelState::unknown; }, scene);
  const auto middle_of = [&](double azimuth) {
    const VoxelView view = draw_voxels(*s.grid, s.scene, Projection::parallel(azimuth, 0, {0, 0, 1.1}, 200, 100, 100));
    return Eigen::Vector3i(view.rgba.at(50, 50, 0), view.rgba.at(50, 50, 1), view.rgba.at(50, 50, 2));
  };
  const Eigen::Vector3i through = middle_of(0), behind = middle_of(std::numbers::pi);
  EXPECT_GT(behind.y(), behind.x() * 3 / 2);   // green alone
  EXPECT_GT(through.x(), behind.x() + 20);     // green through sand
  EXPECT_GT(through.y(), through.z());
}

TEST(VoxelView, ABoxOfTrianglesLooksLikeABox) {
  const auto view_of = [](bool triangles) {
    scene::Solid solid = testing::box({0.6, 0.1, 1.1}, {0.2, 0.3, 0.4});
    solid.X_WS.linear() = rotation_from_yaw_pitch_roll(0.5, 0.2, 0);
    if (triangles) {
      solid.shape = scene::Shape::mesh;
      solid.mesh = std::make_shared<const scene::MeshSolid>(mesh::make_box(solid.size, 1));
    }
    scene::Scene scene;
    scene.solids.push_back(solid);
    const Situation s = testing::around_the_origin(5, [](int, int, int) { return voxel::VoxelState::known; }, scene);
    return draw_voxels(*s.grid, s.scene, Projection::parallel(0.7, 0.3, {0.4, 0, 1.1}, 150, 200, 200));
  };
  const VoxelView box = view_of(false), mesh = view_of(true);
  int shown = 0, different = 0;
  for (int v = 0; v < 200; ++v)
    for (int u = 0; u < 200; ++u) {
      shown += box.rgba.at(u, v, 3) != 0;
      for (int c = 0; c < 4; ++c) {
        if (std::abs(box.rgba.at(u, v, c) - mesh.rgba.at(u, v, c)) <= 2) continue;
        ++different;
        break;
      }
    }
  EXPECT_GT(shown, 3000);
  EXPECT_LT(different, shown / 100) << "but for pixels on an edge";
}

}  // namespace
}  // namespace periplus::nbv
