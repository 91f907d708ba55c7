#include "common/object_model/grid_projection.h"

#include <algorithm>

namespace periplus::object_model {

namespace {
constexpr double kNearestCorner = 1e-3;  // what is nearer to the camera's plane is not seen through [m]
}

GridProjection::GridProjection(const Pinhole& pinhole, const Pose& X_WC, const voxel::GridGeometry& geometry) {
  const Pose X_CG = X_WC.inverse() * geometry.X_WG;
  Eigen::Matrix3d K;
  K << pinhole.fx, 0, pinhole.cx, 0, pinhole.fy, pinhole.cy, 0, 0, 1;
  m.leftCols<3>() = K * X_CG.linear() * geometry.voxel_size;
  m.col(3) = K * X_CG.translation();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) camera.m[r][c] = static_cast<float>(m(r, c));
  }
  camera.width = pinhole.width;
  camera.height = pinhole.height;
  half = 0.5 * m.row(2).head<3>().cwiseAbs().sum();
}

BrickView::BrickView(const GridProjection& projection, int bx, int by, int bz) : near(1e9), far(-1e9) {
  double u0 = 1e9, u1 = -1e9, v0 = 1e9, v1 = -1e9;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d q = projection.m * Eigen::Vector4d(8 * (bx + (c & 1)), 8 * (by + (c >> 1 & 1)), 8 * (bz + (c >> 2)), 1);
    near = std::min(near, q.z());
    far = std::max(far, q.z());
    u0 = std::min(u0, q.x() / q.z());
    u1 = std::max(u1, q.x() / q.z());
    v0 = std::min(v0, q.y() / q.z());
    v1 = std::max(v1, q.y() / q.z());
  }
  out_of_view = far < kNearestCorner;
  in_front = near > kNearestCorner;
  if (!in_front) return;
  const int right = projection.camera.width - 1, bottom = projection.camera.height - 1;
  out_of_view = u1 < 0 || v1 < 0 || u0 > right || v0 > bottom;
  if (out_of_view) return;
  inside = u0 >= 0 && v0 >= 0 && u1 <= right && v1 <= bottom;
  x0 = std::max(0, static_cast<int>(u0));
  y0 = std::max(0, static_cast<int>(v0));
  x1 = static_cast<int>(std::min(static_cast<double>(right), u1 + 1));
  y1 = static_cast<int>(std::min(static_cast<double>(bottom), v1 + 1));
}

}  // namespace periplus::object_model
