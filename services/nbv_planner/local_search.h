// Derivative-free local minimisation with BOBYQA (Powell 2009; NLopt), the bounded successor of the NEWUOA of thesis 3.1.1.
#pragma once

#include <functional>
#include <vector>

namespace periplus::nbv {

struct LocalSearchOptions {
  std::vector<double> step;      // trust region at the start, along each variable
  std::vector<double> lower, upper;
  double end = 1e-3;             // accuracy asked for: trust region at the end, in the variables' units
  int max_evaluations = 60;
};

struct LocalSearchResult {
  std::vector<double> x;         // the best point that was evaluated, never worse than the start
  double value = 0;
  int evaluations = 0;
};

// Starts at x (moved into the bounds). Too few evaluations for a quadratic model (2 n + 3): returns the start's value.
// Exceptions of `f` pass through. Throws Error(bad_input) for arrays of different lengths.
LocalSearchResult minimize(const std::function<double(const std::vector<double>&)>& f, std::vector<double> x,
                           const LocalSearchOptions& options);

}  // namespace periplus::nbv
