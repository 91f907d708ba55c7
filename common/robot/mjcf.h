// A robot as MuJoCo's own XML (MJCF), and its compiled model.
#pragma once

#include <string>
#include <vector>

#include "common/robot/robot_model.h"
#include "common/robot/urdf.h"

namespace periplus::robot {

// Names of the six scalar joints in front: x y z yaw pitch roll of the base.
inline constexpr const char* kBaseJoints[6] = {"base_x", "base_y", "base_z", "base_yaw", "base_pitch", "base_roll"};

// MJCF of `urdf` with its root on six scalar joints: three slides, then hinges about z, y, x, so that R = Rz Ry Rx. Bodies
// and joints keep the URDF's names, depth first; capsules become geoms without contacts (named as the capsules, group 1),
// cameras become MuJoCo cameras (x right, y up, looking along -z).
std::string write_mjcf(const Urdf& urdf, const std::vector<Capsule>& capsules, const std::vector<Camera>& cameras);

}  // namespace periplus::robot
