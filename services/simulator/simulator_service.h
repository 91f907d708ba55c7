// The simulator on the bus: joint commands in, robot states, images and, if asked for, the truth out.
#pragma once

#include <memory>
#include <string>

#include "common/service/service.h"
#include "services/simulator/settings.h"

namespace periplus::simulator {

struct SimulatorOptions {
  std::string scene_file, robot_file;  // the robot's URDF stands beside its YAML
  bool truth = false;
};

class SimulatorService {
 public:
  // Throws Error for a scene or robot that cannot be used.
  SimulatorService(service::Service& service, const SimulatorSettings& settings, const SimulatorOptions& options);
  ~SimulatorService();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::simulator
