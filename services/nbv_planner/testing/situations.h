// Situations with known answers, for the planner's tests.
#pragma once

#include <cmath>
#include <numbers>

#include "common/core/random.h"
#include "services/nbv_planner/situation.h"

namespace periplus::nbv::testing {

// An object's grid, side `n` voxels of 2 cm, its middle 1.1 m above the origin; all of it known but what `unknown` says.
template <class State>
Situation around_the_origin(int n, State state, scene::Scene scene = {}) {
  voxel::GridGeometry g;
  g.voxel_size = 0.02;
  g.size = {n, n, n};
  g.X_WG = make_pose({-n * 0.01, -n * 0.01, 1.1 - n * 0.01}, Eigen::Matrix3d::Identity());
  auto grid = std::make_shared<voxel::OccupancyGrid>(g);
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) grid->set_state({x, y, z}, state(x, y, z));
    }
  }
  grid->revision = 1;
  Situation s;
  s.grid = grid;
  s.scene = std::move(scene);
  s.collision = std::make_shared<scene::CollisionWorld>(s.scene);
  s.rig = {Pinhole::from_vertical_fov(640, 480, 25 * std::numbers::pi / 180), 0.144};
  return s;
}

inline scene::Solid box(const Eigen::Vector3d& center, const Eigen::Vector3d& size) {
  scene::Solid s;
  s.name = "box";
  s.size = size;
  s.X_WS = make_pose(center, Eigen::Matrix3d::Identity());
  return s;
}

// A block of 0.3 m, known all over but for its whole face at +x.
inline Situation patch_at_plus_x(scene::Scene scene = {}) {
  return around_the_origin(
      15, [](int x, int, int) { return x == 14 ? voxel::VoxelState::unknown : voxel::VoxelState::known; }, std::move(scene));
}

}  // namespace periplus::nbv::testing
