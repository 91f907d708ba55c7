#include "services/nbv_planner/local_search.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include "common/core/error.h"

namespace periplus::nbv {
namespace {

struct State {
  const std::function<double(const std::vector<double>&)>& f;
  nlopt_opt optimizer;
  LocalSearchResult best;
  std::exception_ptr error;
};

double evaluate(unsigned n, const double* x, double*, void* data) {
  State& state = *static_cast<State*>(data);
  try {
    const std::vector<double> point(x, x + n);
    const double value = state.f(point);
    if (state.best.evaluations++ == 0 || value < state.best.value) {
      state.best.value = value;
      state.best.x = point;
    }
    return value;
  } catch (...) {  // may not pass through a C library
    state.error = std::current_exception();
    nlopt_force_stop(state.optimizer);
    return 0;
  }
}

}  // namespace

LocalSearchResult minimize(const std::function<double(const std::vector<double>&)>& f, std::vector<double> x,
                           const LocalSearchOptions& options) {
  const std::size_t n = x.size();
  require(n >= 2 && options.step.size() == n && options.lower.size() == n && options.upper.size() == n,
          ErrorCode::bad_input, "local search: steps and bounds must be as many as variables, two at least");
  for (std::size_t i = 0; i < n; ++i) x[i] = std::clamp(x[i], options.lower[i], options.upper[i]);
  if (options.max_evaluations < static_cast<int>(2 * n + 3)) return {x, f(x), 1};
  const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimizer(
      nlopt_create(NLOPT_LN_BOBYQA, static_cast<unsigned>(n)), nlopt_destroy);
  State state{f, optimizer.get(), {x, 0, 0}, nullptr};
  nlopt_set_min_objective(optimizer.get(), evaluate, &state);
  nlopt_set_lower_bounds(optimizer.get(), options.lower.data());
  nlopt_set_upper_bounds(optimizer.get(), options.upper.data());
  nlopt_set_initial_step(optimizer.get(), options.step.data());
  nlopt_set_xtol_abs1(optimizer.get(), options.end);
  nlopt_set_maxeval(optimizer.get(), options.max_evaluations);
  double value = 0;
  // However it ends (accuracy, budget, rounding in the quadratic model), the best point seen is the answer.
  nlopt_optimize(optimizer.get(), x.data(), &value);
  if (state.error) std::rethrow_exception(state.error);
  if (state.best.evaluations == 0) return {x, f(x), 1};
  return state.best;
}

}  // namespace periplus::nbv
