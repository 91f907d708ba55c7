// Cameras calibrated from views of a chessboard (Zhang 2000, by OpenCV's calibrateCamera and stereoCalibrate), and views that
// would spoil the calibration recognised. Frames are optical ones (x right, y down, z forward); lengths are in the unit of the
// chessboard's square; errors are root mean square distances between corners found and corners reprojected [px].
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "common/geometry/calibration.h"
#include "services/vision_server/chessboard.h"

namespace periplus::vision {

struct NamedView {
  std::string name;  // of the image, for errors
  BoardView board;
};

struct CalibrationSettings {
  int least_views = 8;         // that differ; 3 at least
  int radial = 2;              // radial coefficients estimated: 2 (k1, k2) or 3 (k3, for wide lenses and many views)
  double outlier_px = 1;       // a view is an outlier above this error
  double outlier_factor = 4;   // and above this many times the median
  double same_view_px = 2;     // views whose corners all lie nearer to each other count once
  double least_tilt_rad = 0.26;  // by which the board's normals differ between some two views
  double focal_sigma = 0.02;   // greatest standard deviation of the focal length, as a share of it
  void check() const;          // throws Error(bad_input)
};

// Views that cannot be used, all of them, each with its reason. An Error(bad_input) whose message lists them.
struct ViewFault {
  std::string name, why;
};
class BadViews : public Error {
 public:
  explicit BadViews(std::vector<ViewFault> faults);
  const std::vector<ViewFault>& faults() const { return faults_; }

 private:
  std::vector<ViewFault> faults_;
};

struct FittedView {
  std::string name;
  double error_px = 0;
  double edge_px = 0;                                // how sharp, as in BoardView
  std::vector<Eigen::Vector2d> corners, reprojected;  // [px]
};

struct CameraFit {
  int width = 0, height = 0;                        // [px]
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();  // [px]
  std::vector<double> distortion;                   // plumb_bob: k1 k2 p1 p2 k3
  double rms_px = 0;
  double focal_sigma_px = 0;                        // standard deviation of fx, of fy if greater
  double coverage = 0;                              // share of the image, in 8 x 6 cells, that shows corners in some view
  std::vector<FittedView> views;
  // Undistorted: R = I, P the greatest pinhole camera within the distorted image.
  CameraCalibration undistorted() const;
};

struct PairFit {
  CameraFit left, right;                            // errors and reprojections are the pair's
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // p_right = R p_left + T
  Eigen::Vector3d T = Eigen::Vector3d::Zero();
  Eigen::Matrix3d E = Eigen::Matrix3d::Zero(), F = Eigen::Matrix3d::Zero();
  Eigen::Matrix4d Q = Eigen::Matrix4d::Zero();      // (u, v, disparity, 1) to homogeneous points (OpenCV's stereoRectify)
  double rms_px = 0;                                // over both eyes
  double row_px = 0;                                // root mean square by which rectified rows differ
  CameraCalibration left_rectified, right_rectified;  // zero disparity at infinity, all pixels valid
  double baseline() const { return T.norm(); }
};

// Throws BadViews naming views of the same board pose (where too few others are left) and outliers; Error(bad_input) where
// there are too few views, where they do not determine the focal length (no tilt among them), or where the numbers make no camera.
CameraFit calibrate_camera(const std::vector<NamedView>& views, int width, int height, const Chessboard& board,
                           const CalibrationSettings& settings = {});

// `pairs`: left and right view of the same moment. Boards whose corners can be listed from either end are brought into the
// same order. Throws as calibrate_camera; BadViews also for pairs whose eyes are exchanged or do not show the same moment, told
// from their relative pose against that of the others; Error(bad_input) where left and right are exchanged throughout, or the
// cameras do not stand side by side.
PairFit calibrate_pair(const std::vector<std::pair<NamedView, NamedView>>& pairs, int width, int height, const Chessboard& board,
                       const CalibrationSettings& settings = {});

}  // namespace periplus::vision
