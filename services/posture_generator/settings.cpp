#include "services/posture_generator/settings.h"

#include <numbers>
#include <string>

#include "common/core/config.h"

namespace periplus::posture {

Settings read_settings(const config::Node& node) {
  Settings s;
  const auto length = [&](const char* key, double& value) { node.read(key, value, {.minimum = 0, .maximum = 10}); };
  const auto angle = [&](const char* key, double& value) {
    double degrees = value * 180 / std::numbers::pi;
    if (node.read(key, degrees, {.minimum = -180, .maximum = 180})) value = degrees * std::numbers::pi / 180;
  };
  node.read("max_iterations", s.max_iterations, {.minimum = 1, .maximum = 10000});
  node.read("patience", s.patience, {.minimum = 1, .maximum = 10000});
  node.read("starts", s.starts, {.minimum = 1, .maximum = 9});
  node.read("tolerance", s.tolerance, {.minimum = 1e-9, .maximum = 1});
  node.read("constraint_tolerance", s.constraint_tolerance, {.minimum = 1e-9, .maximum = 1e-2});
  node.read("accepted_violation", s.accepted_violation, {.minimum = 1e-9, .maximum = 1e-2});
  length("self_distance_m", s.self_distance);
  length("scene_distance_m", s.scene_distance);
  length("object_distance_m", s.object_distance);
  node.read("object_cell_m", s.object_cell, {.minimum = 1e-3, .maximum = 1});
  node.read("distance_range_m", s.distance_range, {.minimum = 0.05, .maximum = 5});
  length("equilibrium_distance_m", s.equilibrium_distance);
  node.read("equilibrium_share", s.equilibrium_share, {.minimum = 0, .maximum = 0.5});
  length("stance_x_m", s.stance_x);
  length("stance_y_min_m", s.stance_y_min);
  length("stance_y_max_m", s.stance_y_max);
  angle("stance_yaw_out_deg", s.stance_yaw_out);
  angle("stance_yaw_in_deg", s.stance_yaw_in);
  length("base_lower_m", s.base_lower);
  length("base_rise_m", s.base_rise);
  angle("base_pitch_min_deg", s.base_pitch_min);
  angle("base_pitch_max_deg", s.base_pitch_max);
  angle("base_roll_deg", s.base_roll);
  node.read("torque_share", s.torque_share, {.minimum = 0.01, .maximum = 1});
  return s;
}

}  // namespace periplus::posture
