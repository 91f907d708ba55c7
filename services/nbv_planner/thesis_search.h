// The thesis' search (3.3): poses sampled around the object, denser near it and inside it where it is large, then iterative
// local searches on f_e in two stages: a run or two from each of the best samples, then more from the best result, until a
// run gives nothing (3.16). The trust region of a run is a voxel's size times the distance (3.3.1).
//
// All degrees of freedom that the limits leave: x, y, z, yaw, pitch, and roll where it is allowed. BOBYQA and Nelder-Mead
// keep height, pitch and roll as bounds, so that their interval terms are left out of f_e (3.4.4); NEWUOA and sampling
// alone have them in f_e.
#pragma once

#include <cstdint>
#include <functional>

#include "services/nbv_planner/evaluation.h"

namespace periplus::nbv {

struct PlannedView;
struct SearchSettings;
class TaskRunner;

enum class ThesisLocal { bobyqa, newuoa, nelder_mead, none };

struct ThesisSettings {
  ThesisLocal local = ThesisLocal::bobyqa;  // none: sampling alone, with the whole budget
  int samples = 300;
  int starts = 10;              // of the first stage
  int first_stage_runs = 2;     // from each start, each from where the last ended
  int finalists = 2;            // of the second stage
  int second_stage_runs = 8;    // at most, from each of these
  int run_evaluations = 60;     // at most, of one run
  double trust_region = 10;     // times the voxel's size, per metre of distance [1/m]
  double end = 1e-3;            // rho_end [m], angles by the distance

  bool operator==(const ThesisSettings&) const = default;
};

// Throws Error(bad_input) naming a number that cannot be.
void check(const ThesisSettings& settings);

// Budget, threads and time: view_search.h, as are the errors.
PlannedView thesis_search(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& search, TaskRunner& runner,
                          const std::function<void(double)>& poll);

}  // namespace periplus::nbv
