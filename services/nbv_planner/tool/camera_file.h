// A camera, or a pair, as `periplus nbv` takes it from a YAML (deploy/cameras): what it sees, what it can measure, where it may
// stand. Metres, pixels; degrees where the key says so.
//
//   schema: periplus-camera-1
//   name: hand-held
//   resolution_px: [640, 480]
//   horizontal_fov_deg: 60      # or vertical_fov_deg, or focal_px: [fx, fy] with center_px: [cx, cy]
//   baseline_m: 0               # of a rectified pair; 0 or absent: one camera
//   measures_m: [0.6, 2.5]      # along the optical axis; absent: the planner's configuration says
//   head_radius_m: 0.10         # kept free about each eye; absent: the planner's configuration says
//   limits: {height_m: [0.3, 2.0], distance_m: [0.6, 2.5], pitch_deg: [-60, 80], roll_deg: 0, yaw_deg: [-180, 180]}
//   body: {lower_m: [-0.2, -0.4, 0], upper_m: [0.2, 0.4, 1.5]}   # what must stand free below the camera; absent: nothing
//   scene: ../scenes/bunny.yaml # obstacles, beside this file; absent: none
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/geometry/camera.h"
#include "common/robot/robot_model.h"

namespace periplus::nbv {

struct CameraFile {
  std::string name;
  StereoRig rig;
  robot::ViewLimits limits;
  std::optional<robot::BodyBox> body;
  std::optional<Eigen::Vector2d> measures;  // least and greatest depth [m]
  std::optional<double> head_radius;        // [m]
  std::string scene;                        // path as written; empty: none
};

// Throws Error(bad_input) with file, line, key and what is expected.
CameraFile parse_camera(std::string_view yaml, const std::string& name);
// The scene's path comes back relative to the working folder. Throws Error(io) if the file cannot be read.
CameraFile load_camera(const std::string& path);

}  // namespace periplus::nbv
