// Whether one point of a situation is in sight of another: by rays, not by pixels. Cheap beside a rendering.
#pragma once

#include "services/nbv_planner/situation.h"

namespace periplus::nbv {

// True if the straight way from p_WA to p_WB meets no occupied voxel and no solid of the scene. World frame [m].
bool in_sight(const Situation& situation, const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB);

}  // namespace periplus::nbv
