// A whole-body posture that puts the left eye where a view wants it (thesis 2.1, 3.3.3), or the reason why there is none.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "services/posture_generator/posture_problem.h"

namespace periplus::posture {

struct Posture {
  bool feasible = false;
  // Where infeasible: the constraint that was violated most in the best attempt (names as PostureProblem's), or
  // torque:<joint>.
  std::string failed_constraint;
  double violation = 0;          // of that constraint [m, rad, or Nm beyond the limit]
  Eigen::VectorXd q;             // the best attempt, also where infeasible; empty if refused before any
  Pose2 left_foot, right_foot;   // soles
  Eigen::Vector3d center_of_mass = Eigen::Vector3d::Zero();
  double camera_error = 0;       // [m]
  double camera_error_angle = 0; // [rad]
  int iterations = 0;            // of all attempts
};

// Immutable but for caches of its own: one instance per thread.
class PostureGenerator {
 public:
  PostureGenerator(std::shared_ptr<const robot::RobotModel> robot, const Settings& settings);

  // X_WC: pose of the left eye (optical frame) in the world. `start`: configuration to begin with (moved on the floor to
  // where its eye is below the target), instead of half-sitting.
  // Deterministic. Throws Error(not_finite | bad_size | bad_input) for input that is no pose or no configuration.
  Posture generate(const Pose& X_WC, const Surroundings& surroundings, const std::optional<Eigen::VectorXd>& start = {}) const;

  const robot::RobotModel& robot() const { return *facts_.robot(); }
  const RobotFacts& facts() const { return facts_; }

 private:
  Eigen::VectorXd moved_below(const Eigen::VectorXd& q, const Pose& X_WC, double turn) const;
  std::string head_collision(const Pose& X_WC, const Surroundings& surroundings) const;
  void assess(PostureProblem& problem, const Eigen::VectorXd& x, const Pose& X_WC, Posture& posture) const;

  RobotFacts facts_;
};

}  // namespace periplus::posture
