// Footsteps along a path: the first ones bring the feet from the last posture's arrangement to the half-sitting stance,
// those between follow the path, the last ones put the feet into the new posture's arrangement (thesis 5.2.1, 5.2.3).
// Sole poses on the floor, world frame; left and right alternate.
#pragma once

#include <vector>

#include "common/geometry/pose.h"
#include "services/walk_planner/path_planner.h"

namespace periplus::walk {

// Where a sole may land, in the frame of the standing sole; y and yaw are counted outwards (to the side of the foot
// that moves).
struct StepRegion {
  double x_min = -0.15, x_max = 0.20;      // [m]
  double y_min = 0.15, y_max = 0.26;       // [m]
  double yaw_out = 0.314, yaw_in = 0.174;  // [rad], both positive
};

struct StepSettings {
  StepRegion step;
  // Feet of a posture may stand further apart and turned out more than those of a step on the way.
  StepRegion posture{-0.17, 0.17, 0.14, 0.275, 0.70, 0.18};
  double clearance = 0.14;  // least lateral distance, seen from either foot [m]
  int most_steps = 1000;

  void check() const;  // throws Error(bad_input)
};

struct Feet {
  Pose2 left, right;
};

struct Footstep {
  bool left = true;  // the foot that moves
  Pose2 sole;        // where it lands
};

inline Pose2 middle(const Feet& feet) { return middle(feet.left, feet.right); }
// Half-sitting feet about a body pose: soles parallel, `half_width` [m] to each side.
Feet stance(const Pose2& body, double half_width);
// The moving foot's pose in the standing foot's frame, mirrored so that y and yaw are outwards.
Pose2 outward(const Pose2& standing, const Pose2& moving, bool moving_left);
// May the foot land there? `posture`: with the wider limits of a posture's feet.
bool may_land(const StepSettings& settings, const Pose2& standing, const Pose2& moving, bool moving_left, bool posture);

// Steps from `start` to exactly `goal` along `path` (body poses from the middle of the start feet to the middle of the
// goal feet). Empty if the feet stand there already (1e-4 m, 1e-4 rad). Throws Error(walk_no_path) if the feet of
// start or goal cannot be reached by steps within the limits.
std::vector<Footstep> plan_footsteps(const Feet& start, const Feet& goal, const std::vector<Pose2>& path,
                                     double half_width, const StepSettings& settings = {});

}  // namespace periplus::walk
