// The surface of an occupancy grid and the solids around it, drawn into pixels: seen along parallel lines from any side, or by
// a camera. Unknown voxels are green, known ones grey, those of the environment brown; solids are sand-coloured, and glassy
// where they stand before the object.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <utility>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "common/scene/scene.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::nbv {

// World points to (u, v, nearness): u to the right and v down in pixels, nearness linear over the picture and greater for what
// is nearer to the viewer.
class Projection {
 public:
  // Parallel lines. The viewer stands at `azimuth` (from +x towards +y) and `elevation` [rad] around `middle`, which
  // appears in the picture's middle.
  static Projection parallel(double azimuth, double elevation, const Eigen::Vector3d& middle, double px_per_m, int width, int height);
  // Straight from above, +x to the right, +y up.
  static Projection above(const Eigen::Vector3d& middle, double px_per_m, int width, int height);
  static Projection camera(const Pose& X_WC, const Pinhole& camera);

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_W) const;
  Eigen::Vector2d point(const Eigen::Vector3d& p_W) const { return (*this)(p_W).head<2>(); }
  // False for what stands behind a camera or closer than 5 cm.
  bool before(const Eigen::Vector3d& p_W) const;
  // Towards the viewer from a point, not normalised.
  Eigen::Vector3d to_viewer(const Eigen::Vector3d& p_W) const;
  int width() const { return width_; }
  int height() const { return height_; }
  bool is_camera() const { return is_camera_; }
  double px_per_m() const { return scale_; }  // of parallel lines
  // The same picture with `factor` times as many pixels each way.
  Projection finer(int factor) const;

 private:
  bool is_camera_ = false;
  int width_ = 0, height_ = 0;
  Pose X_CW_ = Pose::Identity();  // camera, or the viewer's axes: right, down, away
  Pinhole pinhole_;
  double scale_ = 1;              // [px/m], parallel lines
  Eigen::Vector2d shift_{0, 0};   // [px]
};

struct VoxelView {
  ImageU8 rgba;     // see-through where nothing is
  ImageF nearness;  // of voxels and of solids behind them; -infinity where nothing is
};

VoxelView draw_voxels(const voxel::OccupancyGrid& grid, const scene::Scene& scene, const Projection& projection);

}  // namespace periplus::nbv
