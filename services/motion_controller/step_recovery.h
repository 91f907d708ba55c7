// Taking up a walk that was broken off, because its controller died: where in the steps the robot stands, and how a
// foot that is still in the air comes down.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "services/motion_controller/trajectory.h"
#include "services/motion_controller/walking_pattern.h"
#include "services/motion_controller/whole_body_ik.h"

namespace periplus::motion {

struct WalkPlace {
  std::size_t done = 0;       // steps that need not be begun any more; with a lifted foot, its own one included
  std::optional<int> lifted;  // the foot of step done - 1 that is in the air
};

// Throws Error(motion_robot_fault) if a foot is in the air and none of the steps explains it.
WalkPlace find_place(const std::vector<Step>& steps, const Pose& X_left, const Pose& X_right);

// Puts a lifted foot down without falling: the centre of mass comes to rest over the standing foot, then the foot
// rises, travels and is lowered to its landing. Statically stable throughout; it cannot be cut short.
class LandFoot : public Trajectory {
 public:
  // Errors as of WalkMotion.
  LandFoot(std::shared_ptr<const robot::RobotModel> model, const Eigen::VectorXd& start, int foot, const Pose2& landing,
           const GaitSettings& gait = {}, const MotionLimits& limits = {});

  double fraction(std::size_t executed) const override;
  std::string describe(std::size_t executed) const override;
  void halt(std::size_t) override {}

 private:
  void move(const BodyTarget& to, double duration);

  WholeBodyIk ik_;
  MotionLimits limits_;
  int foot_;
  BodyTarget now_;
  Eigen::VectorXd q_;
};

}  // namespace periplus::motion
