#include "services/walk_planner/walk_planner.h"

#include <cmath>
#include <utility>

namespace periplus::walk {

double half_stance_width(const std::shared_ptr<const robot::RobotModel>& robot) {
  robot::Kinematics kinematics(robot);
  kinematics.set(robot->half_sitting());
  return 0.5 * (kinematics.X_WS_left().translation() - kinematics.X_WS_right().translation()).head<2>().norm();
}

WalkPlan plan_walk(const FloorSpace& floor, double half_width, const Feet& start, const Feet& goal, std::uint64_t seed,
                   const WalkSettings& settings) {
  WalkPlan plan;
  Path path = plan_path(floor, middle(start), middle(goal), seed, settings.path);
  plan.steps = plan_footsteps(start, goal, path.poses, half_width, settings.steps);
  plan.length = path.length();
  plan.samples = path.samples;
  plan.path = std::move(path.poses);
  return plan;
}

}  // namespace periplus::walk
