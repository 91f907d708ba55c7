// What stands behind RobotModel. Only for common/robot and common/render.
#pragma once

#include <mujoco/mujoco.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/robot/mjcf.h"
#include "common/robot/mujoco_model.h"
#include "common/robot/robot_model.h"

namespace periplus::robot {

struct RobotModel::Impl {
  std::string name, urdf_text, yaml_text, mjcf, base_link;
  std::vector<Joint> joints;
  std::vector<Capsule> capsules;
  std::vector<std::pair<int, int>> self_collision_pairs;
  std::vector<Camera> cameras;
  Foot left_foot, right_foot;
  ViewLimits view_limits;
  BodyBox body_box;
  double mass = 0;
  Pose2 sole_middle;          // of half-sitting, seen from the base's floor frame
  double base_height = 0;     // of half-sitting [m]
  MjModelPtr mj;              // qpos and dof addresses equal the indices of q
  std::map<std::string, int, std::less<>> bodies;  // link -> MuJoCo body
};

}  // namespace periplus::robot
