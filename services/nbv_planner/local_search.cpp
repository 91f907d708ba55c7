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
  std::vector<double> origin, scale;  // point = origin + scale * the optimiser's variables
  LocalSearchResult best;
  std::exception_ptr error;
};

double evaluate(unsigned n, const double* x, double*, void* data) {
  State& state = *static_cast<State*>(data);
  try {
    std::vector<double> point(n);
    for (unsigned i = 0; i < n; ++i) point[i] = state.origin[i] + state.scale[i] * x[i];
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

nlopt_algorithm algorithm_of(LocalMethod method) {
  switch (method) {
    case LocalMethod::newuoa: return NLOPT_LN_NEWUOA;
    case LocalMethod::nelder_mead: return NLOPT_LN_NELDERMEAD;
    default: return NLOPT_LN_BOBYQA;
  }
}

}  // namespace

LocalSearchResult minimize(const std::function<double(const std::vector<double>&)>& f, std::vector<double> x,
                           const LocalSearchOptions& options) {
  const std::size_t n = x.size();
  require(n >= 2 && options.step.size() == n && options.lower.size() == n && options.upper.size() == n,
          ErrorCode::bad_input, "local search: steps and bounds must be as many as variables, two at least");
  const bool bounded = options.method != LocalMethod::newuoa;
  for (std::size_t i = 0; i < n && bounded; ++i) x[i] = std::clamp(x[i], options.lower[i], options.upper[i]);
  const std::size_t least = options.method == LocalMethod::nelder_mead ? n + 2 : 2 * n + 3;
  if (options.max_evaluations < static_cast<int>(least)) return {x, f(x), 1};
  const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimizer(
      nlopt_create(algorithm_of(options.method), static_cast<unsigned>(n)), nlopt_destroy);
  State state{f, optimizer.get(), std::vector<double>(n, 0.0), std::vector<double>(n, 1.0), {x, 0, 0}, nullptr};
  std::vector<double> step = options.step;
  double end = options.end;
  if (!bounded) {  // NEWUOA's trust region is a ball: the variables are scaled so that it begins with the steps
    state.origin = x;
    state.scale = options.step;
    end /= *std::min_element(step.begin(), step.end());
    x.assign(n, 0.0);
    step.assign(n, 1.0);
  } else {
    nlopt_set_lower_bounds(optimizer.get(), options.lower.data());
    nlopt_set_upper_bounds(optimizer.get(), options.upper.data());
  }
  nlopt_set_min_objective(optimizer.get(), evaluate, &state);
  nlopt_set_initial_step(optimizer.get(), step.data());
  nlopt_set_xtol_abs1(optimizer.get(), end);
  nlopt_set_maxeval(optimizer.get(), options.max_evaluations);
  double value = 0;
  // However it ends (accuracy, budget, rounding in the quadratic model), the best point seen is the answer.
  nlopt_optimize(optimizer.get(), x.data(), &value);
  if (state.error) std::rethrow_exception(state.error);
  if (state.best.evaluations == 0) return {state.best.x, f(state.best.x), 1};
  return state.best;
}

}  // namespace periplus::nbv
