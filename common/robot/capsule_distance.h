// Distances between capsules in closed form (Ericson, Real-Time Collision Detection, 2005, section 5.1.9).
#pragma once

#include <Eigen/Core>

namespace periplus::robot {

struct ClosestPoints {
  Eigen::Vector3d on_first, on_second;  // on the axes
  double distance = 0;                  // between the axes [m]
};

// Closest points of segments a1-b1 and a2-b2; segments may be points. Of parallel ones the middle of the overlap is not
// sought: one valid pair is given.
ClosestPoints closest_points(const Eigen::Vector3d& a1, const Eigen::Vector3d& b1, const Eigen::Vector3d& a2, const Eigen::Vector3d& b2);

}  // namespace periplus::robot
