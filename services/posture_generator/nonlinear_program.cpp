#include "services/posture_generator/nonlinear_program.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wnon-virtual-dtor"
#include <coin/IpIpoptApplication.hpp>
#include <coin/IpSolveStatistics.hpp>
#include <coin/IpTNLP.hpp>
#pragma GCC diagnostic pop

#include <algorithm>
#include <limits>

#include "common/core/error.h"

namespace periplus::posture {

namespace {

using Ipopt::Index;
using Ipopt::Number;

// Below this violation a start is not hopeless: it may stand still there while the objective falls.
constexpr double kNearlyFeasible = 1e-2;

// Dense problem as Ipopt wants to be asked.
class Adapter : public Ipopt::TNLP {
 public:
  Adapter(NonlinearProgram& program, const Eigen::VectorXd& start, int patience, SolverResult& result)
      : program_(program),
        variables_(program.variable_bounds()),
        constraints_(program.constraint_bounds()),
        start_(start),
        patience_(patience),
        result_(result) {}

  bool get_nlp_info(Index& n, Index& m, Index& nonzeros, Index& hessian_nonzeros, IndexStyleEnum& style) override {
    n = static_cast<Index>(variables_.lower.size());
    m = static_cast<Index>(constraints_.lower.size());
    nonzeros = n * m;
    hessian_nonzeros = 0;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* x_lower, Number* x_upper, Index m, Number* g_lower, Number* g_upper) override {
    Eigen::VectorXd::Map(x_lower, n) = variables_.lower;
    Eigen::VectorXd::Map(x_upper, n) = variables_.upper;
    Eigen::VectorXd::Map(g_lower, m) = constraints_.lower;
    Eigen::VectorXd::Map(g_upper, m) = constraints_.upper;
    return true;
  }

  bool get_starting_point(Index n, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    Eigen::VectorXd::Map(x, n) = start_.cwiseMax(variables_.lower).cwiseMin(variables_.upper);
    return true;
  }

  bool eval_f(Index n, const Number* x, bool, Number& value) override {
    value = program_.objective(Eigen::VectorXd::Map(x, n));
    return true;
  }

  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override {
    Eigen::VectorXd::Map(gradient, n) = program_.objective_gradient(Eigen::VectorXd::Map(x, n));
    return true;
  }

  bool eval_g(Index n, const Number* x, bool, Index m, Number* g) override {
    Eigen::VectorXd::Map(g, m) = program_.constraints(Eigen::VectorXd::Map(x, n));
    return true;
  }

  bool eval_jac_g(Index n, const Number* x, bool, Index m, Index, Index* rows, Index* columns, Number* values) override {
    if (values != nullptr) {
      Eigen::Map<RowMatrix>(values, m, n) = program_.constraint_jacobian(Eigen::VectorXd::Map(x, n));
      return true;
    }
    for (Index i = 0; i < m; ++i) {
      for (Index j = 0; j < n; ++j) {
        rows[i * n + j] = i;
        columns[i * n + j] = j;
      }
    }
    return true;
  }

  bool intermediate_callback(Ipopt::AlgorithmMode, Index iteration, Number, Number infeasibility, Number, Number, Number, Number, Number,
                             Number, Index, const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    if (infeasibility < 0.9 * least_infeasibility_) {
      least_infeasibility_ = infeasibility;
      least_at_ = iteration;
    }
    return infeasibility < kNearlyFeasible || iteration - least_at_ < patience_;
  }

  void finalize_solution(Ipopt::SolverReturn status, Index n, const Number* x, const Number*, const Number*, Index, const Number*,
                         const Number*, Number, const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    result_.x = Eigen::VectorXd::Map(x, n);
    result_.converged = status == Ipopt::SUCCESS || status == Ipopt::STOP_AT_ACCEPTABLE_POINT;
  }

 private:
  NonlinearProgram& program_;
  const Bounds variables_, constraints_;
  const Eigen::VectorXd start_;
  const int patience_;
  double least_infeasibility_ = std::numeric_limits<double>::infinity();
  Index least_at_ = 0;
  SolverResult& result_;
};

}  // namespace

SolverResult minimize(NonlinearProgram& program, const Eigen::VectorXd& start, const SolverOptions& options) {
  Ipopt::SmartPtr<Ipopt::IpoptApplication> application = new Ipopt::IpoptApplication(false);
  auto& o = *application->Options();
  o.SetIntegerValue("print_level", 0);
  o.SetStringValue("sb", "yes");
  o.SetStringValue("option_file_name", "");
  // Nearly all time is MUMPS': a solve for every remembered pair of the Hessian, and as many again to refine it. For a problem
  // this small and well scaled two pairs converge as soon as six, and neither refinement nor MUMPS' own scaling helps.
  o.SetStringValue("hessian_approximation", "limited-memory");
  o.SetIntegerValue("limited_memory_max_history", 2);
  o.SetIntegerValue("min_refinement_steps", 0);
  o.SetIntegerValue("max_refinement_steps", 0);
  o.SetIntegerValue("mumps_permuting_scaling", 0);
  o.SetIntegerValue("mumps_scaling", 0);
  o.SetIntegerValue("max_iter", options.max_iterations);
  o.SetNumericValue("tol", options.tolerance);
  o.SetNumericValue("constr_viol_tol", options.constraint_tolerance);
  o.SetNumericValue("dual_inf_tol", 10);
  o.SetNumericValue("compl_inf_tol", 1e-2);
  o.SetNumericValue("acceptable_tol", 10 * options.tolerance);
  o.SetNumericValue("acceptable_constr_viol_tol", options.constraint_tolerance);
  o.SetIntegerValue("acceptable_iter", 5);
  // Ipopt widens bounds by this much; a joint must not stand beyond its limit.
  o.SetNumericValue("bound_relax_factor", 0);
  require(application->Initialize() == Ipopt::Solve_Succeeded, ErrorCode::internal, "Ipopt does not start");
  SolverResult result;
  const Ipopt::SmartPtr<Ipopt::TNLP> adapter = new Adapter(program, start, options.patience, result);
  application->OptimizeTNLP(adapter);
  const Ipopt::SmartPtr<Ipopt::SolveStatistics> statistics = application->Statistics();
  if (Ipopt::IsValid(statistics)) result.iterations = statistics->IterationCount();
  return result;
}

double violation(const Eigen::VectorXd& values, const Bounds& bounds) {
  if (values.size() == 0) return 0;
  return std::max({0.0, (bounds.lower - values).maxCoeff(), (values - bounds.upper).maxCoeff()});
}

}  // namespace periplus::posture
