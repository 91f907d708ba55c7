// A whole walk as joint commands: to the half-sitting stance over the feet as they stand, along the walking pattern,
// ending in half-sitting over the last steps' feet (thesis 5.2.1, 5.2.5).
#pragma once

#include <memory>
#include <vector>

#include "services/motion_controller/posture_motion.h"
#include "services/motion_controller/trajectory.h"
#include "services/motion_controller/walking_pattern.h"

namespace periplus::motion {

class WalkMotion : public Trajectory {
 public:
  // From configuration `start` (dof() numbers). Throws Error(bad_input) for steps that cannot be executed, and as
  // PostureMotion. Without steps the robot only goes to the half-sitting stance.
  WalkMotion(std::shared_ptr<const robot::RobotModel> model, const Eigen::VectorXd& start,
             const std::vector<Step>& steps, const GaitSettings& gait = {}, const PostureSettings& posture = {},
             const MotionLimits& limits = {});

  double fraction(std::size_t executed) const override;
  std::string describe(std::size_t executed) const override;
  void halt(std::size_t executed) override;

  // Commands before the pattern begins; pattern() tick k+1 is command lead() + k.
  std::size_t lead() const { return lead_ ? lead_->commands().size() : 0; }
  const WalkingPattern& pattern() const { return *pattern_; }

 private:
  void follow_pattern(std::size_t from_command);
  bool can_follow_pattern(std::size_t from_command);  // and has

  WholeBodyIk ik_;
  MotionLimits limits_;
  std::size_t steps_ = 0;
  double height_ = 0;                    // of the centre of mass [m]
  Eigen::VectorXd start_, stance_;       // present, and where the pattern begins
  std::unique_ptr<PostureMotion> lead_;  // from one to the other, where they differ
  std::unique_ptr<WalkingPattern> pattern_;
};

}  // namespace periplus::motion
