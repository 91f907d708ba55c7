#include "services/posture_generator/nonlinear_program.h"

#include <gtest/gtest.h>

namespace periplus::posture {

namespace {
// Nearest point to (2, 1) on the circle of radius 1 with x <= limit.
class Circle : public NonlinearProgram {
 public:
  explicit Circle(double limit, double radius = 1) : limit_(limit), radius_(radius) {}
  Bounds variable_bounds() const override { return {Eigen::Vector2d(-5, -5), Eigen::Vector2d(limit_, 5)}; }
  Bounds constraint_bounds() const override { return {Eigen::VectorXd::Constant(1, radius_ * radius_), Eigen::VectorXd::Constant(1, radius_ * radius_)}; }
  double objective(const Eigen::VectorXd& x) override { return 0.5 * (x - target_).squaredNorm(); }
  Eigen::VectorXd objective_gradient(const Eigen::VectorXd& x) override { return x - target_; }
  const Eigen::VectorXd& constraints(const Eigen::VectorXd& x) override { return g_ = Eigen::VectorXd::Constant(1, x.squaredNorm()); }
  const RowMatrix& constraint_jacobian(const Eigen::VectorXd& x) override { return J_ = 2 * x.transpose(); }

 private:
  double limit_, radius_;
  const Eigen::VectorXd target_ = Eigen::Vector2d(2, 1);
  Eigen::VectorXd g_;
  RowMatrix J_;
};
}  // namespace

TEST(NonlinearProgram, FindsTheConstrainedMinimum) {
  Circle circle(5);
  const SolverResult result = minimize(circle, Eigen::Vector2d(0.3, -0.4), {});
  EXPECT_TRUE(result.converged);
  EXPECT_GT(result.iterations, 0);
  EXPECT_LT((result.x - Eigen::Vector2d(2, 1).normalized()).norm(), 1e-3);
}

TEST(NonlinearProgram, KeepsVariableBounds) {
  Circle circle(0.5);
  const SolverResult result = minimize(circle, Eigen::Vector2d(7, 7), {});
  EXPECT_TRUE(result.converged);
  EXPECT_LE(result.x[0], 0.5);
  EXPECT_NEAR(result.x[1], std::sqrt(0.75), 1e-3);
}

TEST(NonlinearProgram, SaysWhenThereIsNone) {
  Circle circle(5, 20);  // beyond the bounds
  const SolverResult result = minimize(circle, Eigen::Vector2d(1, 1), {});
  EXPECT_FALSE(result.converged);
  EXPECT_GT(violation(circle.constraints(result.x), circle.constraint_bounds()), 1);
}

TEST(NonlinearProgram, ViolationIsTheLargestExcess) {
  const Bounds bounds{Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 1)};
  EXPECT_EQ(violation(Eigen::Vector2d(0.5, 1), bounds), 0);
  EXPECT_DOUBLE_EQ(violation(Eigen::Vector2d(-0.25, 1.5), bounds), 0.5);
}

}  // namespace periplus::posture
