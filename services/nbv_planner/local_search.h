// Derivative-free local minimisation (NLopt): the methods that the thesis compares (3.1.1, 3.4.4, 3.4.5).
#pragma once

#include <functional>
#include <vector>

namespace periplus::nbv {

enum class LocalMethod {
  bobyqa,       // Powell 2009: quadratic models within bounds
  newuoa,       // Powell 2004: quadratic models, without bounds
  nelder_mead,  // simplex, within bounds
};

struct LocalSearchOptions {
  std::vector<double> step;      // trust region (or simplex) at the start, along each variable
  std::vector<double> lower, upper;  // not looked at by newuoa
  double end = 1e-3;             // accuracy asked for: trust region at the end, in the variables' units
  int max_evaluations = 60;
  LocalMethod method = LocalMethod::bobyqa;
};

struct LocalSearchResult {
  std::vector<double> x;         // the best point that was evaluated, never worse than the start
  double value = 0;
  int evaluations = 0;
};

// Starts at x (moved into the bounds). Too few evaluations for a quadratic model (2 n + 3): returns the start's value; a
// simplex takes n + 2. Exceptions of `f` pass through. Throws Error(bad_input) for arrays of different lengths.
LocalSearchResult minimize(const std::function<double(const std::vector<double>&)>& f, std::vector<double> x,
                           const LocalSearchOptions& options);

}  // namespace periplus::nbv
