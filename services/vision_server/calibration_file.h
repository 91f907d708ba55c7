// A calibration as files: YAML in the format of OpenCV's FileStorage, with the names that OpenCV's samples and ROS's camera_info
// files use, and a camera file for `periplus nbv`.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "services/vision_server/calibration.h"

namespace periplus::vision {

// One camera: image_width, image_height, camera_name, camera_matrix, distortion_model (plumb_bob), distortion_coefficients
// (k1 k2 p1 p2 k3), rectification_matrix, projection_matrix (as ROS's camera_info files; P(0,3) = -fx * baseline), and
// board_width, board_height, square_size, nframes, avg_reprojection_error (as OpenCV's calibration sample).
std::string camera_yaml(const CameraFit& fit, const CameraCalibration& rectified, const std::string& name, const Chessboard& board);

// The pair: image_width, image_height, M1, D1, M2, D2, R, T, E, F, R1, P1, R2, P2, Q (as OpenCV's stereo_calib sample), board
// and errors as above.
std::string pair_yaml(const PairFit& fit, const Chessboard& board);

// periplus-camera-1 (deploy/cameras) of what is seen after rectification. `rig` in metres; baseline 0 for one camera.
std::string view_camera_yaml(const StereoRig& rig, const std::string& name);

// Writes `files`, names and bytes, into the folder, which is made if it is not there. Throws Error(io) with the reason where one
// cannot be written: none is then, and what was there stays, that a calibration is never half of another.
void write_files(const std::string& folder, const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace periplus::vision
