// Single and iterated local searches on f_e (thesis 3.3.1, 3.3.2), as 3.4 compares them: the six variables are x, y, z [m],
// yaw, pitch and roll [rad] as they are, with one rho for all of them.
#pragma once

#include "integration-tests/thesis_comparisons/worlds.h"
#include "services/nbv_planner/local_search.h"

namespace periplus::thesis_comparisons {

struct LocalOptions {
  nbv::LocalMethod method = nbv::LocalMethod::newuoa;
  double rho_beg = 0.4;           // 3.4.2 and 3.4.7
  double rho_end = 1e-5;
  int runs = 1;                   // each from where the last ended, until one gives nothing
  int run_evaluations = 3000;
  int evaluations = 1000000;      // of all runs
};

struct LocalOutcome {
  Pose X_WC = Pose::Identity();
  nbv::Evaluation evaluation;
  double f_e = 0;                 // 3.15, all terms
  double f_free = 0;              // without those of height, pitch and roll, which a search within bounds does without (3.4.4)
  bool within = true;             // height, pitch and roll are within their limits
  int runs = 0, evaluations = 0;
  std::vector<std::pair<int, double>> course;  // what was minimised, at each evaluation that improved it

  // The evaluation at which the search came within `slack` of what it ended with.
  int evaluations_to(double slack) const;
};

// f_e, and f_free, of a pose.
LocalOutcome outcome_of(const State& state, const Pose& X_WC, nbv::Evaluator::Workspace& workspace);
// NEWUOA minimises f_e; BOBYQA and Nelder-Mead f_free within bounds on height, pitch and roll.
LocalOutcome search_locally(const State& state, const Pose& start, const LocalOptions& options, nbv::Evaluator::Workspace& workspace);

}  // namespace periplus::thesis_comparisons
