// A grid and its bricks as a camera sees them: what every pass over a depth map begins with.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "common/geometry/camera.h"
#include "common/object_model/carving_kernel.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::object_model {

struct GridProjection {
  // `X_WC`: the camera's pose.
  GridProjection(const Pinhole& pinhole, const Pose& X_WC, const voxel::GridGeometry& geometry);

  Eigen::Matrix<double, 3, 4> m;  // (u w, v w, w) of a point of the grid frame [voxels] is m (x, y, z, 1); pixels, metres
  GridCamera camera;              // the same in single precision
  double half;                    // from a voxel's centre to its nearest corner, in depth [m]
};

// A brick's corners in the image.
struct BrickView {
  BrickView(const GridProjection& projection, int bx, int by, int bz);

  double near, far;      // depth of the nearest and the farthest corner [m]
  bool out_of_view;      // behind the camera or beside the image
  bool in_front;         // wholly in front of the camera; what follows holds only then
  bool inside = false;   // wholly within the image
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // the pixels that it may cover, both ends included, within the image
};

// Calls visit(brick, bx, by, bz, view) for each brick that is not out of view, in order.
template <class Visit>
void for_each_brick_in_view(const GridProjection& projection, const voxel::GridGeometry& geometry, Visit&& visit) {
  const Eigen::Vector3i nb = geometry.bricks();
  std::size_t brick = 0;
  for (int bx = 0; bx < nb.x(); ++bx)
    for (int by = 0; by < nb.y(); ++by)
      for (int bz = 0; bz < nb.z(); ++bz, ++brick) {
        const BrickView view(projection, bx, by, bz);
        if (!view.out_of_view) visit(brick, bx, by, bz, view);
      }
}

}  // namespace periplus::object_model
