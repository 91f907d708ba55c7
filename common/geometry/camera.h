// Camera models. Pixel centres stand at integer coordinates; u to the right, v down.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace periplus {

// Pinhole without distortion.
struct Pinhole {
  int width = 640, height = 480;        // [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  // [px]

  // Square pixels, principal point in the middle ((width - 1) / 2, (height - 1) / 2).
  static Pinhole from_vertical_fov(int width, int height, double fovy_rad);

  // Pixel of a point in the optical frame; z must be positive.
  Eigen::Vector2d project(const Eigen::Vector3d& p_C) const {
    return {fx * p_C.x() / p_C.z() + cx, fy * p_C.y() / p_C.z() + cy};
  }
  // Point at depth z along the optical axis.
  Eigen::Vector3d back_project(double u, double v, double z) const {
    return {(u - cx) / fx * z, (v - cy) / fy * z, z};
  }
  double horizontal_fov() const;  // [rad]
  double vertical_fov() const;    // [rad]
  // Throws Error(bad_input): sizes 1..8192, finite positive focal lengths, principal point within the image.
  void check() const;
};

// Rectified pair: both eyes are `camera`, the right one stands at +baseline along the left one's x axis.
struct StereoRig {
  Pinhole camera;
  double baseline = 0;  // [m]

  // Disparity [px] of a point at depth z [m] and back.
  double disparity(double z) const { return camera.fx * baseline / z; }
  double depth(double disparity_px) const { return camera.fx * baseline / disparity_px; }
  void check() const;
};

}  // namespace periplus
