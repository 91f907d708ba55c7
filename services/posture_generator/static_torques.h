// Joint torques of the robot standing still on both feet.
#pragma once

#include <Eigen/Core>

#include "common/robot/robot_model.h"

namespace periplus::posture {

// Of q: the weight stands on the two soles, shared so that the centre of pressure lies below the centre of mass, each
// foot's force vertical and as far beside the sole's origin as the centre of mass is beside the line through both.
// dof() numbers; the first six are what the shares leave over, zero up to rounding [N, Nm].
Eigen::VectorXd static_torques(const robot::Kinematics& kinematics);

}  // namespace periplus::posture
