// Constrained minimisation with exact first derivatives: Ipopt behind a plain interface (Waechter and Biegler 2006; it
// takes the place of the thesis' FSQP, 2.1.1).
#pragma once

#include <Eigen/Core>

namespace periplus::posture {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Bounds {
  Eigen::VectorXd lower, upper;   // +-1e20: none
};

class NonlinearProgram {
 public:
  virtual ~NonlinearProgram() = default;
  virtual Bounds variable_bounds() const = 0;
  virtual Bounds constraint_bounds() const = 0;
  virtual double objective(const Eigen::VectorXd& x) = 0;
  virtual Eigen::VectorXd objective_gradient(const Eigen::VectorXd& x) = 0;
  virtual const Eigen::VectorXd& constraints(const Eigen::VectorXd& x) = 0;
  virtual const RowMatrix& constraint_jacobian(const Eigen::VectorXd& x) = 0;   // constraints x variables
};

struct SolverOptions {
  int max_iterations = 80;
  double tolerance = 1e-4;
  double constraint_tolerance = 1e-5;
  int patience = 15;       // iterations in which the violation has to fall by a tenth, or the start is given up as hopeless
};

struct SolverResult {
  Eigen::VectorXd x;       // the last iterate, also where it did not converge; empty if there was none
  int iterations = 0;
  bool converged = false;
};

// Limited-memory Hessian. The start is clamped into the bounds. Deterministic.
SolverResult minimize(NonlinearProgram& program, const Eigen::VectorXd& start, const SolverOptions& options);

// Largest excess of the bounds.
double violation(const Eigen::VectorXd& values, const Bounds& bounds);

}  // namespace periplus::posture
