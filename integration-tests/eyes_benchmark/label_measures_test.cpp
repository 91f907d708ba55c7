#include "integration-tests/eyes_benchmark/label_measures.h"

#include <gtest/gtest.h>

namespace periplus::eyes_benchmark {
namespace {

// A ball on the table, before one pair of eyes; what a model of it would say is set by hand.
struct Ball {
  Stage stage;
  std::vector<Shot> shots{1};
  std::vector<object_model::Perception> perceptions{1};
  voxel::OccupancyGrid grid;

  Ball() : stage(make_stage("ball", ball())) {
    const Pose X_WC = six_views(stage).front();
    Shot& shot = shots.front();
    shot.pair.rig = robot_eyes();
    shot.left = true_eye(stage, shot.pair.rig.camera, X_WC);
    shot.right = true_eye(stage, shot.pair.rig.camera, X_WC * Eigen::Translation3d(shot.pair.rig.baseline, 0, 0));
    perceptions.front().view_id = "view-0";
    for (const EyeTruth* eye : {&shot.left, &shot.right}) perceptions.front().depth.push_back({shot.pair.rig.camera, eye->X_WC, eye->depth, eye->depth, {}});
    grid = voxel::OccupancyGrid(voxel::GridGeometry::from_box(stage.box.X_WB, stage.box.size, 0.02));
  }
  static mesh::TriangleMesh ball() {
    mesh::TriangleMesh m = mesh::make_sphere(0.3, 1);
    mesh::transform(m, make_pose({0, 0, kTable + 0.15}, Eigen::Matrix3d::Identity()));
    return m;
  }
  LabelQuality quality() const { return label_quality(grid, reached_voxels(shots, grid.geometry()), *stage.tree, shots, perceptions); }
  // Towards the eye (1), or away from it (-1), from the middle of the ball [m].
  Eigen::Vector3i voxel_towards_eye(double distance) const {
    return grid.geometry().voxel_of(stage.middle + distance * (shots.front().left.X_WC.translation() - stage.middle).normalized());
  }
};

TEST(LabelMeasures, WhatIsSeenPlainlyAndNotKnownCounts) {
  Ball s;
  const LabelQuality before = s.quality();
  EXPECT_GT(before.plain, 50u);
  EXPECT_EQ(before.plain_unknown, before.plain);
  EXPECT_EQ(before.known, 0u);
  const Eigen::Vector3i facing = s.voxel_towards_eye(0.148);
  s.grid.set_state(facing, voxel::VoxelState::known);
  EXPECT_EQ(s.quality().plain_unknown, before.plain - 1);
  EXPECT_EQ(s.quality().known_hidden, 0u);
  s.grid.set_state(facing, voxel::VoxelState::empty);
  EXPECT_EQ(s.quality().plain_emptied, 1u);
  // Without a measured depth nothing is seen plainly.
  for (object_model::DepthMap& map : s.perceptions.front().depth) std::fill(map.depth.data.begin(), map.depth.data.end(), 0.0f);
  EXPECT_EQ(s.quality().plain, 0u);
}

TEST(LabelMeasures, KnownWithinAndBehindTheObjectIsHidden) {
  Ball s;
  for (const double distance : {0.17, 0.0, -0.17}) s.grid.set_state(s.voxel_towards_eye(distance), voxel::VoxelState::known);
  EXPECT_EQ(s.quality().known, 3u);
  EXPECT_EQ(s.quality().known_hidden, 2u);
}

}  // namespace
}  // namespace periplus::eyes_benchmark
