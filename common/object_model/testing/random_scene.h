// Random objects in random grids, seen from around: what the properties of carving and labels are tested over.
#pragma once

#include <cstdlib>

#include "common/object_model/evidence.h"
#include "common/object_model/testing/random_solids.h"

namespace periplus::object_model::testing {

// Six in every build; PERIPLUS_CARVING_SCENES says how many.
inline int scene_count() {
  const char* asked = std::getenv("PERIPLUS_CARVING_SCENES");
  return asked ? std::atoi(asked) : 6;
}

// A camera of random views.
struct Lens {
  int width = 160, height = 120;            // [px]
  double least_fov = 0.25, most_fov = 0.9;  // vertical [rad]
};

// Random solids in a random grid, and exact depths from around: near and far, through lenses of any width, with the object wholly in the
// image or not; in every other scene a few pixels have no depth.
struct RandomScene {
  Random random;
  RandomSolids solids;
  voxel::OccupancyGrid grid;
  std::vector<DepthMap> maps;

  explicit RandomScene(int number, const Lens& lens = {})
      : random(static_cast<std::uint64_t>(number) + 1000), solids(random, {0, 0, 1}), grid(random_grid()) {
    for (int n = 0; n < 8; ++n) {
      const double yaw = 0.25 * std::numbers::pi * (n + random.uniform()), pitch = random.uniform(-1.2, 1.2), distance = random.uniform(0.6, 2);
      const Eigen::Vector3d eye(distance * std::cos(yaw) * std::cos(pitch), distance * std::sin(yaw) * std::cos(pitch), 1 + distance * std::sin(pitch));
      Pose X_WC = look_at(eye, Eigen::Vector3d(0, 0, 1) + random_in_cube(random, 0.08));
      X_WC.rotate(Eigen::AngleAxisd(random.uniform(-0.6, 0.6), Eigen::Vector3d::UnitZ()));
      maps.push_back(exact_depth(solids.mesh_W(), Pinhole::from_vertical_fov(lens.width, lens.height, random.uniform(lens.least_fov, lens.most_fov)), X_WC, 5));
      if (number % 2 == 0) continue;
      for (int k = 0; k < 200; ++k) maps.back().depth.data[random.below(maps.back().depth.data.size())] = 0;
    }
  }

  const voxel::GridGeometry& geometry() const { return grid.geometry(); }
  PixelLimits limits(const DepthMap& map) const { return pixel_limits(map, geometry(), CarvingSettings{}, false, nullptr); }
  // The grid after all maps have carved.
  voxel::OccupancyGrid carved(double margin_voxels) const {
    voxel::OccupancyGrid out = grid;
    Evidence none(geometry());
    for (const DepthMap& map : maps) empty_voxels(seen_through(out, map.camera, map.X_WC, limits(map).limit, margin_voxels), 1, out, none);
    return out;
  }

 private:
  // It may leave some of the object outside.
  voxel::GridGeometry random_grid() {
    const Pose X_WB = make_pose(Eigen::Vector3d(0, 0, 1) + random_in_cube(random, 0.03), random_rotation(random));
    return voxel::GridGeometry::from_box(X_WB, Eigen::Vector3d::Constant(0.4) + random_in_cube(random, 0.1), random.uniform(0.008, 0.025));
  }
};

}  // namespace periplus::object_model::testing
