#include "integration-tests/eyes_benchmark/model_measures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "common/object_model/evidence.h"

namespace periplus::eyes_benchmark {
namespace {

constexpr double kBall = 0.1, kSide = 0.01;
const Eigen::Vector3d kMiddle(0.3, -0.2, 1);

mesh::TriangleMesh sphere(double radius) {
  mesh::TriangleMesh m = mesh::make_sphere(2 * radius, 1);
  mesh::transform(m, make_pose(kMiddle, Eigen::Matrix3d::Identity()));
  return m;
}

voxel::GridGeometry grid_about(const Eigen::Matrix3d& R = Eigen::Matrix3d::Identity()) {
  return voxel::GridGeometry::from_box(make_pose(kMiddle, R), Eigen::Vector3d::Constant(0.26), kSide);
}

template <class Visit>
void each_voxel(const voxel::GridGeometry& g, Visit visit) {
  for (int x = 0; x < g.size.x(); ++x)
    for (int y = 0; y < g.size.y(); ++y)
      for (int z = 0; z < g.size.z(); ++z) visit(Eigen::Vector3i(x, y, z));
}

// In a turned grid as well: inside by the radius, touching by the nearest and farthest point of the cube. The polyhedron lies within
// `facets` of the ball.
TEST(VoxelTruth, Ball) {
  constexpr double kFacets = 0.0015;
  for (const Eigen::Matrix3d& R : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), rotation_from_yaw_pitch_roll(0.4, 0.3, 0.2)}) {
    const voxel::GridGeometry g = grid_about(R);
    const VoxelTruth truth = voxel_truth(sphere(kBall), g, 200000, 1);
    int inside = 0, touching = 0;
    each_voxel(g, [&](const Eigen::Vector3i& v) {
      const std::size_t i = voxel::voxel_index(g, v);
      const Eigen::Vector3d p = g.center_world(v) - kMiddle;
      inside += truth.inside[i];
      touching += truth.touching[i];
      if (p.norm() < kBall - kFacets) {
        EXPECT_TRUE(truth.inside[i]);
      }
      if (p.norm() > kBall + kFacets) {
        EXPECT_FALSE(truth.inside[i]);
      }
      const Eigen::Array3d q = (R.transpose() * p).cwiseAbs().array();
      const double nearest = (q - kSide / 2).max(0.0).matrix().norm(), farthest = (q + kSide / 2).matrix().norm();
      if (nearest > kBall + kFacets || farthest < kBall - kFacets) {
        EXPECT_FALSE(truth.touching[i]);
      }
      if (std::abs(p.norm() - kBall) < kSide / 2 - kFacets) {
        EXPECT_TRUE(truth.touching[i]);
      }
    });
    const double volume = 4 * M_PI / 3 * std::pow(kBall / kSide, 3);
    EXPECT_NEAR(inside / volume, 1, 0.03);
    EXPECT_GT(touching, 0);
  }
}

// A ball open at its pole is still full, as two of the three axes say so.
TEST(VoxelTruth, ASmallHoleDoesNoHarm) {
  mesh::TriangleMesh open = sphere(kBall);
  std::erase_if(open.triangles, [&](const Eigen::Vector3i& t) { return open.vertices[static_cast<std::size_t>(t[0])].z() > kMiddle.z() + 0.97 * kBall; });
  const voxel::GridGeometry g = grid_about();
  const VoxelTruth truth = voxel_truth(open, g, 1000, 1);
  each_voxel(g, [&](const Eigen::Vector3i& v) {
    const Eigen::Vector3d p = g.center_world(v) - kMiddle;
    if (p.norm() < 0.9 * kBall) {
      EXPECT_TRUE(truth.inside[voxel::voxel_index(g, v)]);
    }
  });
}

// One known voxel: the share of a ball's points within reach of it is that of the reach's own ball.
TEST(CoveredShare, OneVoxelsBall) {
  voxel::OccupancyGrid grid(grid_about());
  const Eigen::Vector3i v(13, 13, 13);
  grid.set_state(v, voxel::VoxelState::known);
  std::vector<Eigen::Vector3d> points;
  const Eigen::Vector3d c = grid.geometry().center_world(v);
  for (int i = 0; i < 400; ++i) points.push_back(c + Eigen::Vector3d(1e-4 * (i + 0.5), 0, 0));  // 0 to 40 mm away
  EXPECT_NEAR(covered_share(grid, points, 1.5 * kSide), 15 / 40.0, 1e-12);
  EXPECT_NEAR(covered_share(grid, points, kSide), 10 / 40.0, 1e-12);
  EXPECT_EQ(covered_share(grid, {}, kSide), 0);
  // Unknown and environment cover nothing.
  grid.set_state(v, voxel::VoxelState::environment);
  EXPECT_EQ(covered_share(grid, points, kSide), 0);
}

// A surface 3 mm outside the true ball, a tenth of it 8 mm inside, some of it under the floor.
TEST(SurfaceError, ShellsAboutABall) {
  const mesh::TriangleMesh ball = sphere(kBall);
  object_model::SurfaceMesh surface;
  const auto samples = mesh::sample_surface(ball, 1000, 3);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d n = (samples[i].point - kMiddle).normalized();
    surface.vertices.push_back((samples[i].point + (i % 10 == 0 ? -0.008 : 0.003) * n).cast<float>());
  }
  surface.vertices.push_back((kMiddle - Eigen::Vector3d(0, 0, 0.5)).cast<float>());
  const Spread e = surface_error(surface, mesh::TriangleTree(ball), kMiddle.z() - 0.4);
  EXPECT_EQ(e.count, 1000u);
  EXPECT_NEAR(e.median, 0.003, 1e-4);
  EXPECT_NEAR(e.p95, 0.008, 1e-4);
  EXPECT_NEAR(e.mean, 0.9 * 0.003 + 0.1 * 0.008, 1e-4);
}

TEST(CountVoxels, EachKindOnce) {
  const voxel::GridGeometry g = grid_about();
  const VoxelTruth truth = voxel_truth(sphere(kBall), g, 200000, 1);
  // As carved without a fault: the object stands, what is outside is empty.
  voxel::OccupancyGrid grid(g);
  std::size_t inside = 0, touching = 0, volume = 0;
  each_voxel(g, [&](const Eigen::Vector3i& v) {
    const std::size_t i = voxel::voxel_index(g, v);
    if (!truth.inside[i] && !truth.touching[i]) grid.set_state(v, voxel::VoxelState::empty);
    inside += truth.inside[i];
    touching += truth.touching[i];
    volume += truth.inside[i] || truth.touching[i];
  });
  ModelQuality q;
  count_voxels(grid, truth, q);
  EXPECT_EQ(q.inside, inside);
  EXPECT_EQ(q.touching, touching);
  EXPECT_EQ(q.inside_emptied, 0u);
  EXPECT_EQ(q.touching_emptied, 0u);
  EXPECT_EQ(q.ghosts, 0);
  // The middle emptied, two voxels that the surface touches, two ghosts; environment is none.
  grid.set_state({13, 13, 13}, voxel::VoxelState::empty);
  Eigen::Vector3i skin(-1, -1, -1), other_skin = skin;
  each_voxel(g, [&](const Eigen::Vector3i& v) {
    const std::size_t i = voxel::voxel_index(g, v);
    if (truth.touching[i] && !truth.inside[i]) std::swap(skin, other_skin), skin = v;
  });
  ASSERT_GE(other_skin.x(), 0);
  grid.set_state(skin, voxel::VoxelState::empty);
  grid.set_state(other_skin, voxel::VoxelState::empty);
  grid.set_state({0, 0, 0}, voxel::VoxelState::unknown);
  grid.set_state({0, 0, 1}, voxel::VoxelState::known);
  grid.set_state({0, 0, 2}, voxel::VoxelState::environment);
  count_voxels(grid, truth, q);
  EXPECT_EQ(q.inside_emptied, 1u);
  EXPECT_EQ(q.touching_emptied, 2u);
  EXPECT_NEAR(q.ghosts, 2.0 / static_cast<double>(volume), 1e-12);
  EXPECT_NEAR(q.inside_emptied_share(), 1.0 / static_cast<double>(inside), 1e-12);
  EXPECT_THROW(count_voxels(voxel::OccupancyGrid(voxel::GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, 0.01)), truth, q), Error);
}

}  // namespace
}  // namespace periplus::eyes_benchmark
