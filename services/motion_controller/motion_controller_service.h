// The motion controller on the bus: RPCs motion/walk, motion/set_posture, motion/state, motion/halt; commands the robot
// in lockstep on periplus/robot/command and periplus/robot/state.
#pragma once

#include <memory>

#include "common/core/config.h"
#include "common/service/service.h"
#include "services/motion_controller/lockstep.h"
#include "services/motion_controller/posture_motion.h"
#include "services/motion_controller/trajectory.h"
#include "services/motion_controller/walking_pattern.h"

namespace periplus::motion {

struct MotionSettings {
  GaitSettings gait;
  PostureSettings posture;
  MotionLimits limits;
  LockstepSettings lockstep;
  double robot_deadline = 5.0;  // for the robot's first answer [s]
};

// Reads every parameter of config/default.yaml. Throws Error(bad_input) that names file, line and key.
MotionSettings read_settings(const config::Node& configuration);

class MotionControllerService {
 public:
  MotionControllerService(service::Service& service, const MotionSettings& settings);
  ~MotionControllerService();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::motion
