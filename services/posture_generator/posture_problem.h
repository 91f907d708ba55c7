// The posture as constrained optimisation (thesis 2.1-2.15, 3.17): the robot's 36 numbers, of which the joints that move
// neither the feet nor the left eye (the arms, thesis 5.2.4) stay at half-sitting.
//
// Constraints: camera pose (3.17), soles flat on the floor (2.5), centre of mass over the segment between the feet
// (2.6), stance that a step can reach, distances between capsules, to the scene and to the object's grid (2.4); joint
// limits are bounds of the variables (2.3). All derivatives are exact.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "services/posture_generator/nonlinear_program.h"
#include "services/posture_generator/object_obstacle.h"
#include "services/posture_generator/settings.h"

namespace periplus::posture {

// What follows from the robot alone: computed once.
class RobotFacts {
 public:
  RobotFacts(std::shared_ptr<const robot::RobotModel> robot, const Settings& settings);

  const std::shared_ptr<const robot::RobotModel>& robot() const { return robot_; }
  const Settings& settings() const { return settings_; }
  // Indices into q of the variables, base first.
  const std::vector<int>& free() const { return free_; }
  // Capsule pairs that can come near each other by moving the free joints. All others were found far apart, or never
  // change.
  const std::vector<std::pair<int, int>>& pairs() const { return pairs_; }
  // Links that carry capsules, feet and left camera, and for each capsule its place among them.
  const std::vector<std::string>& links() const { return links_; }
  const std::vector<int>& capsule_links() const { return capsule_links_; }
  int left_foot_link() const { return left_foot_link_; }
  int right_foot_link() const { return right_foot_link_; }
  int camera_link() const { return camera_link_; }
  const Eigen::VectorXd& half_sitting() const { return half_sitting_; }

 private:
  int link_number(const std::string& name);
  void find_pairs(const std::vector<std::vector<char>>& moved_by);

  std::shared_ptr<const robot::RobotModel> robot_;
  Settings settings_;
  std::vector<int> free_;
  std::vector<std::pair<int, int>> pairs_;
  std::vector<std::string> links_;
  std::vector<int> capsule_links_;
  int left_foot_link_ = 0, right_foot_link_ = 0, camera_link_ = 0;
  Eigen::VectorXd half_sitting_;
};

// Obstacles; either may be absent. Referenced, not owned.
struct Surroundings {
  const scene::Scene* scene = nullptr;
  const scene::CollisionWorld* collision = nullptr;
  const ObjectObstacle* object = nullptr;
};

class PostureProblem : public NonlinearProgram {
 public:
  // X_WC: pose of the left eye. Both references must outlive the problem.
  PostureProblem(const RobotFacts& facts, const Surroundings& surroundings, const Pose& X_WC);

  Bounds variable_bounds() const override { return variable_bounds_; }
  Bounds constraint_bounds() const override { return constraint_bounds_; }
  double objective(const Eigen::VectorXd& x) override;
  Eigen::VectorXd objective_gradient(const Eigen::VectorXd& x) override;
  const Eigen::VectorXd& constraints(const Eigen::VectorXd& x) override;
  const RowMatrix& constraint_jacobian(const Eigen::VectorXd& x) override;

  Eigen::VectorXd configuration(const Eigen::VectorXd& x) const;   // x -> q
  Eigen::VectorXd variables(const Eigen::VectorXd& q) const;       // q -> x
  // Name of constraint i at x: camera_pose, feet_on_floor, equilibrium, stance, self_collision:a-b,
  // scene_collision:<solid>, object_collision.
  std::string constraint_name(const Eigen::VectorXd& x, int i);

 private:
  void add_bound(double lower, double upper);
  void update(const Eigen::VectorXd& x, bool with_jacobian);
  void camera_rows(bool with_jacobian);
  void feet_rows(bool with_jacobian);
  void distance_rows(bool with_jacobian);
  RowMatrix point_jacobian(int link, const Eigen::Vector3d& p_W) const;

  const RobotFacts& facts_;
  Surroundings surroundings_;
  const Pose X_WC_;
  robot::Kinematics kinematics_;
  Bounds variable_bounds_, constraint_bounds_;
  Eigen::VectorXd x_, g_;
  RowMatrix J_;
  bool has_values_ = false, has_jacobian_ = false;
  std::vector<RowMatrix> link_jacobians_;        // at the links' origins, free columns only
  std::vector<Eigen::Vector3d> link_origins_;
};

}  // namespace periplus::posture
