#include "services/posture_generator/posture_generator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/error.h"
#include "common/robot/capsule_distance.h"
#include "services/posture_generator/static_torques.h"

namespace periplus::posture {

PostureGenerator::PostureGenerator(std::shared_ptr<const robot::RobotModel> robot, const Settings& settings)
    : facts_(std::move(robot), settings) {}

// q moved on the floor, and its base up or down, so that its left eye stands at the target's place and looks its way;
// `turn` turns the body about the eye.
Eigen::VectorXd PostureGenerator::moved_below(const Eigen::VectorXd& q, const Pose& X_WC, double turn) const {
  robot::Kinematics kinematics(facts_.robot());
  kinematics.set(q);
  const Pose eye = kinematics.X_WC("left");
  const Pose2 eye_floor{eye.translation().x(), eye.translation().y(), camera_yaw_pitch_roll(eye).x()};
  const Pose2 target{X_WC.translation().x(), X_WC.translation().y(), camera_yaw_pitch_roll(X_WC).x() + turn};
  const Pose2 base = compose(target, compose(inverse(eye_floor), {q[0], q[1], q[3]}));
  Eigen::VectorXd moved = q;
  moved[0] = base.x;
  moved[1] = base.y;
  moved[3] = base.yaw;
  moved[2] += X_WC.translation().z() - eye.translation().z();
  return moved;
}

// The eye's pose alone places its link: a collision there needs no search.
std::string PostureGenerator::head_collision(const Pose& X_WC, const Surroundings& surroundings) const {
  const robot::Camera& camera = facts_.robot()->camera("left");
  const Pose X_WL = X_WC * camera.X_LC.inverse();
  const Settings& s = facts_.settings();
  for (const robot::Capsule& capsule : facts_.robot()->capsules()) {
    if (capsule.link != camera.link) continue;
    const Eigen::Vector3d a = X_WL * capsule.a, b = X_WL * capsule.b;
    if (surroundings.collision != nullptr) {
      const scene::Closest c = surroundings.collision->capsule_distance(a, b, capsule.radius, s.distance_range);
      if (c.distance < s.scene_distance - s.accepted_violation) {
        return "scene_collision:" + (c.solid >= 0 && surroundings.scene != nullptr ? surroundings.scene->solids[c.solid].name : std::string("room"));
      }
    }
    if (surroundings.object != nullptr &&
        surroundings.object->nearest(a, b, s.distance_range).distance - capsule.radius < s.object_distance - s.accepted_violation) {
      return "object_collision";
    }
  }
  return {};
}

void PostureGenerator::assess(PostureProblem& problem, const Eigen::VectorXd& x, const Pose& X_WC, Posture& posture) const {
  const Settings& s = facts_.settings();
  posture.q = problem.configuration(x);
  robot::Kinematics kinematics(facts_.robot());
  kinematics.set(posture.q);
  posture.left_foot = to_pose2(kinematics.X_WS_left());
  posture.right_foot = to_pose2(kinematics.X_WS_right());
  posture.center_of_mass = kinematics.center_of_mass();
  const Pose eye = kinematics.X_WC("left");
  posture.camera_error = (eye.translation() - X_WC.translation()).norm();
  posture.camera_error_angle = angle_between(eye, X_WC);

  const auto worst = [&](const std::string& name, double excess) {
    if (excess <= posture.violation) return;
    posture.violation = excess;
    posture.failed_constraint = name;
  };
  posture.violation = 0;
  posture.failed_constraint.clear();
  const Eigen::VectorXd g = problem.constraints(x);
  const Bounds bounds = problem.constraint_bounds();
  Eigen::Index i = 0;
  const double excess = (bounds.lower - g).cwiseMax(g - bounds.upper).maxCoeff(&i);
  if (excess > s.accepted_violation) worst(problem.constraint_name(x, static_cast<int>(i)), excess);
  const double beyond = violation(x, problem.variable_bounds());
  if (beyond > s.accepted_violation) worst("joint_limits", beyond);
  // Pairs that the problem left out as never near.
  for (const auto& [a, b] : facts_.robot()->self_collision_pairs()) {
    Eigen::Vector3d a1, b1, a2, b2;
    kinematics.capsule(a, a1, b1);
    kinematics.capsule(b, a2, b2);
    const robot::Capsule &first = facts_.robot()->capsules()[a], &second = facts_.robot()->capsules()[b];
    const double overlap = first.radius + second.radius - robot::closest_points(a1, b1, a2, b2).distance;
    if (overlap > s.accepted_violation) worst("self_collision:" + first.name + "-" + second.name, overlap);
  }
  if (posture.failed_constraint.empty()) {
    const Eigen::VectorXd torques = static_torques(kinematics);
    for (std::size_t j = 0; j < facts_.robot()->joints().size(); ++j) {
      const robot::Joint& joint = facts_.robot()->joints()[j];
      worst("torque:" + joint.name, std::abs(torques[6 + static_cast<Eigen::Index>(j)]) - s.torque_share * joint.max_torque);
    }
  }
  posture.feasible = posture.failed_constraint.empty();
}

Posture PostureGenerator::generate(const Pose& X_WC, const Surroundings& surroundings, const std::optional<Eigen::VectorXd>& start) const {
  const Settings& s = facts_.settings();
  require(is_finite(X_WC), ErrorCode::not_finite, "the camera pose holds a number that is not finite");
  require(X_WC.translation().norm() < 1e4, ErrorCode::bad_input, "the camera pose lies more than 10 km away; positions are in metres");
  require((X_WC.linear() * X_WC.linear().transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-6 && X_WC.linear().determinant() > 0,
          ErrorCode::bad_input, "the camera pose's orientation is no rotation");
  if (start) {
    require(start->size() == facts_.half_sitting().size(), ErrorCode::bad_size,
            "the start configuration must have " + std::to_string(facts_.half_sitting().size()) + " numbers");
    require(start->allFinite(), ErrorCode::not_finite, "the start configuration holds a number that is not finite");
  }

  Posture best;
  best.violation = std::numeric_limits<double>::infinity();
  best.failed_constraint = head_collision(X_WC, surroundings);
  if (!best.failed_constraint.empty()) {
    best.violation = 0;
    return best;
  }

  PostureProblem problem(facts_, surroundings, X_WC);
  const SolverOptions options{s.max_iterations, s.tolerance, s.constraint_tolerance, s.patience};
  int iterations = 0;
  for (int attempt = 0; attempt < s.starts && !best.feasible; ++attempt) {
    constexpr double kTurn = 0.6;  // [rad]
    const double turn = (attempt % 2 == 1 ? 1 : -1) * kTurn * ((attempt + 1) / 2);
    const Eigen::VectorXd& from = start && attempt == 0 ? *start : facts_.half_sitting();
    const SolverResult result = minimize(problem, problem.variables(moved_below(from, X_WC, turn)), options);
    iterations += result.iterations;
    if (result.x.size() == 0 || !result.x.allFinite()) continue;
    Posture posture;
    assess(problem, result.x, X_WC, posture);
    if (posture.feasible || posture.violation < best.violation) best = posture;
  }
  if (best.failed_constraint.empty() && !best.feasible) best.failed_constraint = "solver";
  best.iterations = iterations;
  return best;
}

}  // namespace periplus::posture
