// Poses of the left eye as a person writes them.
#pragma once

#include <string>
#include <string_view>

#include "common/geometry/pose.h"

namespace periplus::nbv {

// "x,y,z,yaw,pitch" or "x,y,z,yaw,pitch,roll" [m, degrees; pitch positive down], or "x,y,z,qw,qx,qy,qz" with the quaternion of
// the optical frame. Throws Error(bad_input | not_finite) naming `what`.
Pose parse_pose(std::string_view text, std::string_view what);

// The first form, so that it reads back to the same pose within 1e-6 m and 1e-4 degrees.
std::string to_text(const Pose& X_WC);

}  // namespace periplus::nbv
