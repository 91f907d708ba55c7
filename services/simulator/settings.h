// Parameters of the simulator, from its YAML file; config/default.yaml says what each means.
#pragma once

#include <cstdint>
#include <string>

#include "common/core/config.h"
#include "common/scene/scene.h"
#include "services/simulator/camera_sensor.h"

namespace periplus::simulator {

struct SimulatorSettings {
  std::uint64_t seed = 1;
  std::string backend = "auto";
  int render_threads = 2;
  int samples = 0;
  CameraSensor left, right, wide;
  int views_kept = 64;
  double joint_limit_slack = 0.01;  // [rad]
  bool silent_cameras = false;
  std::uint64_t fall_at_tick = 0;
};

// Throws Error(bad_input) for unknown keys and values out of range.
SimulatorSettings read_settings(const config::Node& root);

// What the scene says of the cameras goes before the configuration.
void apply(const scene::CameraImperfections& cameras, SimulatorSettings& settings);

}  // namespace periplus::simulator
