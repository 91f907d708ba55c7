// Calibration of one camera of a stereo pair, as ROS 2's CameraInfo carries it (REP 104): how a raw image becomes a
// rectified one.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry/camera.h"

namespace periplus {

struct CameraCalibration {
  int width = 0, height = 0;                                      // [px]
  std::vector<double> distortion;                                 // plumb_bob: k1 k2 p1 p2 k3; empty: none
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();                // of the raw image [px]
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();                // raw to rectified optical frame
  Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();  // of the rectified image; P(0,3) = -fx * baseline

  // An ideal camera; `x_in_left` is where it stands along the left eye's x axis [m].
  static CameraCalibration ideal(const Pinhole& camera, double x_in_left = 0) {
    CameraCalibration c;
    c.width = camera.width;
    c.height = camera.height;
    c.K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
    c.P.leftCols<3>() = c.K;
    c.P(0, 3) = -camera.fx * x_in_left;
    return c;
  }
};

}  // namespace periplus
