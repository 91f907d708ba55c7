// From where the feet stand to where a posture wants them: path, then footsteps (thesis 5.2.1, 5.2.3).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/robot/robot_model.h"
#include "services/walk_planner/footstep_planner.h"
#include "services/walk_planner/path_planner.h"

namespace periplus::walk {

struct WalkSettings {
  PathSettings path;
  StepSettings steps;
};

struct WalkPlan {
  std::vector<Footstep> steps;
  std::vector<Pose2> path;  // body poses
  double length = 0;        // [m]
  int samples = 0;          // random poses that the search drew
};

// Half the distance of the soles in half-sitting [m].
double half_stance_width(const std::shared_ptr<const robot::RobotModel>& robot);

// Errors as of plan_path() and plan_footsteps(). Feet that need not move give an empty plan.
WalkPlan plan_walk(const FloorSpace& floor, double half_width, const Feet& start, const Feet& goal, std::uint64_t seed,
                   const WalkSettings& settings = {});

}  // namespace periplus::walk
