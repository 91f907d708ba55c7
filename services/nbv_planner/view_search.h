// The next best view: global sampling, then iterative BOBYQA in two stages (thesis 3.3.2).
//
// 1. Places around the object, denser near it: most where a random unknown face looks to, the others around the box;
//    heights drawn from a widened range and clamped. From each one wide rendering gives the best orientation.
// 2. The most promising are evaluated exactly; the greatest N_u among them scales the penalties (3.2.1.5).
// 3. From the best of these, some distance apart, one or two runs of BOBYQA on x, y, z, yaw and pitch; each
//    run starts where the last ended. Its trust region is a voxel's size times the distance times `trust_region`.
// 4. From the best results more runs, until they give nothing.
// The answer is the best evaluated pose that satisfies every hard constraint: those with gain before those without,
// then by f_e.
//
// World frame, metres, radians. Deterministic: the same bytes for any number of threads and processes (task_runner.h).
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/situation.h"
#include "services/nbv_planner/task_runner.h"

namespace periplus::nbv {

struct SearchSettings {
  int samples = 160;            // places that are looked around from
  int detailed = 48;            // evaluated exactly
  int starts = 10;              // of the first stage
  int first_stage_runs = 2;     // of BOBYQA from each start
  int finalists = 2;            // of the second stage
  int second_stage_runs = 8;
  int run_evaluations = 45;     // of one run
  int max_evaluations = 1500;   // of everything: one is a wide rendering or a pair of exact ones
  double trust_region = 10;     // times the voxel's size, per metre of distance [1/m]
  double end = 1e-3;            // rho_end [m], angles by the distance
  int threads = 2;
};

struct PlannedView {
  Pose X_WC = Pose::Identity();  // left eye
  Evaluation evaluation;
  double f_e = 0;
  double gain_scale = 0;         // greatest value among the samples: lz, lx and ly of 3.15
  int evaluations = 0;
  bool landmark_term = false;
  bool cut_short = false;        // the runner's time was out before the search had ended by itself
  std::vector<std::pair<std::string, double>> terms;    // Evaluator::terms
  std::vector<std::pair<std::string, double>> seconds;  // by stage
};

// All work goes through `runner`: the same bytes for any runner that has no wall-clock limit. With one, the best that was
// found in time; at least a few places are looked around from in any case.
// `poll` is called now and then from the caller's thread, with the share done (0..1); it may throw to give up.
// Throws Error(nbv_no_reachable_view) if no pose satisfies the hard constraints, or if unknown voxels with a free face are
// left and none of those poses shows one (unless cut short: then a view with gain 0); Error(bad_input | not_finite) for a
// situation that cannot be, naming what to change. Nothing unknown left to see (a complete or an empty model): a view
// with gain 0.
PlannedView plan_view(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& search, TaskRunner& runner,
                      const std::function<void(double)>& poll = {});
// The same with `search.threads` threads of this process.
PlannedView plan_view(const Situation& situation, std::uint64_t seed, const SearchSettings& search,
                      const EvaluationSettings& evaluation, const ConstraintSettings& constraints,
                      const std::function<void(double)>& poll = {});

}  // namespace periplus::nbv
