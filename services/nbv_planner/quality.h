// How well known surface was measured, so that a late view may make the model more accurate and not only more complete (the
// idea of N. Frahm et al., "VIN-NBV", 2025: the gain in quality of a view beside its gain in coverage).
//
// A stereo pair measures depth with sigma_z = z^2 sigma_d / (f B), along its axis; on a surface seen at an angle a of
// incidence the samples lie 1 / cos a farther apart. The quality of a look at a voxel is
//
//   q = max(0, cos a) min(1, (z_ref / z)^2)                                                     0..1
//
// and that of a voxel the best of the looks so far. World frame, metres.
#pragma once

#include <cstdint>
#include <vector>

#include "common/voxel/visibility.h"
#include "services/nbv_planner/situation.h"

namespace periplus::nbv {

struct SurfaceVoxel {
  std::uint32_t voxel = 0;                             // VisibilityScene::index
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();       // its centre
  Eigen::Vector3d normal_W = Eigen::Vector3d::Zero();  // unit, to where it is empty; zero where that cannot be told
};

// Known voxels with an empty neighbour across a face. Normals: away from the occupied voxels within two voxels each way.
std::vector<SurfaceVoxel> known_surface(const voxel::OccupancyGrid& grid);

// q of a look from a left-eye pose. 1 in place of cos a where the normal is not known.
double look_quality(const SurfaceVoxel& s, const Pose& X_WC, double baseline, double reference_distance);

// Of each of `surface`, over the situation's views: the best look of those in which both eyes see more of it than
// `options.more_than_pixels`; 0: none. `scene` watches these voxels.
std::vector<float> quality_so_far(const std::vector<SurfaceVoxel>& surface, const Situation& situation,
                                  const voxel::VisibilityScene& scene, const voxel::PairOptions& options,
                                  double reference_distance);

// Calls visit(voxel) for the watched voxels that both eyes see with more pixels than that, after evaluate_pair.
template <class Visit>
void for_each_watched(voxel::VisibilityWorkspace& w, const StereoRig& rig, int more_than_pixels, Visit&& visit) {
  const auto threshold = static_cast<std::uint32_t>(more_than_pixels);
  if (rig.baseline == 0) {
    for (const voxel::VoxelPixels& v : w.left.watched) {
      if (v.pixels > threshold) visit(v.voxel);
    }
    return;
  }
  w.left_pixels.clear(w.left.watched.size());
  for (const voxel::VoxelPixels& v : w.left.watched) w.left_pixels.add(v);
  for (const voxel::VoxelPixels& v : w.right.watched) {
    if (v.pixels > threshold && w.left_pixels.pixels(v.voxel) > threshold) visit(v.voxel);
  }
}

}  // namespace periplus::nbv
