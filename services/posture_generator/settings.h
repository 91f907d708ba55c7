// What a posture has to keep to (thesis 2.1.1, 2.1.2). The defaults are those measured for the HRP-2-like robot.
#pragma once

namespace periplus::config {
class Node;
}

namespace periplus::posture {

struct Settings {
  int max_iterations = 80;              // of one start of the solver
  int starts = 3;                       // half-sitting behind the camera, then turned to either side
  int patience = 15;                    // iterations in which a start has to lessen its violation by a tenth
  double tolerance = 1e-4;
  double constraint_tolerance = 1e-5;
  double accepted_violation = 1e-4;     // of any constraint in the answer [m, rad]

  double self_distance = 0.01;          // dC_min of 2.4 [m]
  double scene_distance = 0.03;
  double object_distance = 0.03;
  double object_cell = 0.03;            // resolution at which the object's grid is an obstacle [m]
  double distance_range = 0.3;          // beyond it an obstacle has no influence [m]

  double equilibrium_distance = 0.02;   // xi_s of 2.6 [m]
  double equilibrium_share = 0.25;      // least share of the weight on each foot

  // Right foot seen from the left one and the reverse: what the last step of a walk reaches.
  double stance_x = 0.16;               // largest |x| [m]
  double stance_y_min = 0.15, stance_y_max = 0.265;  // [m]
  double stance_yaw_out = 0.66, stance_yaw_in = 0.157;  // [rad]

  double base_lower = 0.40, base_rise = 0.10;        // of the base below and above half-sitting [m]
  double base_pitch_min = -0.7, base_pitch_max = 0.9, base_roll = 0.5;  // [rad]
  double torque_share = 0.9;            // of each joint's largest torque, standing still
};

// Reads all keys of config/default.yaml. Throws Error(bad_input).
Settings read_settings(const config::Node& node);

}  // namespace periplus::posture
