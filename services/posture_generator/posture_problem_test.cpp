#include "services/posture_generator/posture_problem.h"

#include <gtest/gtest.h>

#include "common/core/random.h"
#include "services/posture_generator/testing/object_on_table.h"

namespace periplus::posture {

namespace {

class PostureProblemTest : public ::testing::Test {
 protected:
  PostureProblemTest() { facts = std::make_unique<RobotFacts>(robot, settings); }
  Surroundings surroundings() const { return room.surroundings(); }

  Settings settings;
  const std::shared_ptr<const robot::RobotModel> robot = testing::hrp2like();
  std::unique_ptr<RobotFacts> facts;
  // Before the robot at the origin, and a pillar to its left.
  const testing::ObjectOnTable room{0.75, 0.6, testing::solid("pillar", scene::Shape::cylinder, {0.2, 0.2, 2}, {0, 0.65, 1}), settings};
};

}  // namespace

TEST_F(PostureProblemTest, ArmsAreFixedLegsTrunkAndHeadAreFree) {
  EXPECT_EQ(facts->free().size(), 6u + 12 + 2 + 2);
  EXPECT_GT(facts->pairs().size(), 10u);
  EXPECT_LT(facts->pairs().size(), robot->self_collision_pairs().size());
}

TEST_F(PostureProblemTest, JacobianAgreesWithFiniteDifferences) {
  Random random(21);
  // Obstacles near enough to have influence.
  PostureProblem problem(*facts, surroundings(), look_along({0.3, 0.2, 1.25}, 0.2, 0.3));
  for (int trial = 0; trial < 5; ++trial) {
    Eigen::VectorXd x = problem.variables(robot->half_sitting({0.05, 0.02, 0.1}));
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += random.uniform(-0.1, 0.1);
    const RowMatrix J = problem.constraint_jacobian(x);
    const Eigen::VectorXd gradient = problem.objective_gradient(x);
    constexpr double h = 1e-6;
    int active = 0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      Eigen::VectorXd above = x, below = x;
      above[i] += h;
      below[i] -= h;
      const Eigen::VectorXd g_above = problem.constraints(above), g_below = problem.constraints(below);
      const Eigen::VectorXd difference = (g_above - g_below) / (2 * h);
      const double error = (difference - J.col(i)).cwiseAbs().maxCoeff();
      EXPECT_LT(error, 1e-5) << "variable " << i;
      EXPECT_NEAR((problem.objective(above) - problem.objective(below)) / (2 * h), gradient[i], 1e-6);
    }
    const Eigen::Index obstacle_rows = 2 * static_cast<Eigen::Index>(robot->capsules().size());
    for (Eigen::Index r = J.rows() - obstacle_rows; r < J.rows(); ++r) active += J.row(r).norm() > 0 ? 1 : 0;
    EXPECT_GT(active, 3);
  }
}

TEST_F(PostureProblemTest, HalfSittingKeepsEveryConstraint) {
  robot::Kinematics kinematics(robot);
  kinematics.set(robot->half_sitting({-1, -1, 0.4}));
  PostureProblem problem(*facts, surroundings(), kinematics.X_WC("left"));
  const Eigen::VectorXd x = problem.variables(kinematics.q());
  const Eigen::VectorXd g = problem.constraints(x);
  const Bounds bounds = problem.constraint_bounds();
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    EXPECT_GE(g[i], bounds.lower[i] - 1e-6) << problem.constraint_name(x, static_cast<int>(i));
    EXPECT_LE(g[i], bounds.upper[i] + 1e-6) << problem.constraint_name(x, static_cast<int>(i));
  }
  EXPECT_LT(violation(x, problem.variable_bounds()), 1e-9);
}

TEST_F(PostureProblemTest, ViolationsCarryTheirNames) {
  const auto worst = [&](const Eigen::VectorXd& q, const Pose& X_WC) {
    PostureProblem problem(*facts, surroundings(), X_WC);
    const Eigen::VectorXd x = problem.variables(q);
    const Eigen::VectorXd g = problem.constraints(x);
    const Bounds bounds = problem.constraint_bounds();
    Eigen::Index i = 0;
    (bounds.lower - g).cwiseMax(g - bounds.upper).maxCoeff(&i);
    return problem.constraint_name(x, static_cast<int>(i));
  };
  robot::Kinematics kinematics(robot);
  const auto eye = [&](const Eigen::VectorXd& q) {
    kinematics.set(q);
    return kinematics.X_WC("left");
  };
  const Eigen::VectorXd away = robot->half_sitting({-1, -1, 0}), in_table = robot->half_sitting({0.75, 0, 0});
  EXPECT_EQ(worst(away, look_along({-1, -1, 3}, 0, 0)), "camera_pose");
  EXPECT_EQ(worst(in_table, eye(in_table)).substr(0, 16), "scene_collision:");
  Eigen::VectorXd floating = away;
  floating[2] += 0.1;
  EXPECT_EQ(worst(floating, eye(floating)), "feet_on_floor");
  Eigen::VectorXd bowed = away;
  bowed[6 + robot->joint_index("CHEST_JOINT1")] = 1.0;
  EXPECT_EQ(worst(bowed, eye(bowed)), "equilibrium");
}

}  // namespace periplus::posture
