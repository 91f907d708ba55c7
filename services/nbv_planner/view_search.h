// The next best view (thesis 3.3), by one of three searches:
//
//   fast, thorough   panorama_search.h: places around the object, every orientation from one rendering of each
//   thesis           thesis_search.h: global sampling, then iterative local searches in two stages (3.3.2)
//
// The answer is the best evaluated pose that satisfies every hard constraint: those with gain before those without, then by
// f_e. World frame, metres, radians. Deterministic: the same bytes for any number of threads and processes (task_runner.h)
// and on every instruction set.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/lookahead.h"
#include "services/nbv_planner/panorama_search.h"
#include "services/nbv_planner/situation.h"
#include "services/nbv_planner/task_runner.h"
#include "services/nbv_planner/thesis_search.h"

namespace periplus::nbv {

enum class SearchMethod { fast, thorough, thesis };

struct SearchSettings {
  SearchMethod method = SearchMethod::thorough;
  PanoramaSettings fast = PanoramaSettings::fast(), thorough = PanoramaSettings::thorough();
  ThesisSettings thesis;
  LookaheadSettings lookahead;
  int max_evaluations = 1500;   // of everything: one is a wide rendering or a pair of exact ones
  double time_limit_s = 0;      // wall clock; 0: none
  int threads = 2;
  bool keep_candidates = false; // PlannedView::candidates
  voxel::Simd simd = voxel::Simd::best;  // instructions to compute with; the result does not depend on it
};

// Throws Error(bad_input) naming a number that cannot be.
void check(const SearchSettings& settings);

// A pose that was looked at.
struct ViewCandidate {
  Pose X_WC = Pose::Identity();  // left eye
  double f_e = 0;                // as far as the stage knows it
  const char* stage = "";
};

struct PlannedView {
  Pose X_WC = Pose::Identity();  // left eye
  Evaluation evaluation;
  double f_e = 0;                // without the terms of 3.15 that the search keeps as bounds (3.4.4)
  double gain_scale = 0;         // greatest value among the samples: scale of the penalties (3.2.1.5)
  int evaluations = 0;
  bool landmark_term = false;
  bool cut_short = false;        // the runner's time was out before the search had ended by itself
  std::vector<std::pair<std::string, double>> terms;    // Evaluator::terms, f_e as above
  std::vector<std::pair<std::string, double>> seconds;  // by stage
  std::vector<ViewCandidate> candidates;                // if asked for
};

// The best of given poses by their value alone; limits and penalties are the caller's business. Where only likely surface counts
// (EvaluationSettings::likely_within) and hardly any of it is to be seen, the pose that shows most of all that is unknown. The first of
// equal ones. Throws Error(bad_input) for an empty list.
struct ListedView {
  int index = -1;
  Evaluation evaluation;
};
ListedView choose_view(const Evaluator& evaluator, const std::vector<Pose>& poses, Evaluator::Workspace& workspace);

// All work goes through `runner`: the same bytes for any runner that has no wall-clock limit. With one, the best that was
// found in time; at least a few places are looked around from in any case.
// `poll` is called now and then from the caller's thread, with the share done (0..1); it may throw to give up.
// Throws Error(nbv_no_reachable_view) if no pose satisfies the hard constraints, or if unknown voxels with a free face are
// left and none of those poses shows one (unless cut short: then a view with gain 0); Error(bad_input | not_finite) for a
// situation that cannot be, naming what to change. Nothing unknown left to see (a complete or an empty model): a view
// with gain 0.
PlannedView plan_view(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& search, TaskRunner& runner,
                      const std::function<void(double)>& poll = {});
// The same with `search.threads` threads of this process and its time limit.
PlannedView plan_view(const Situation& situation, std::uint64_t seed, const SearchSettings& search,
                      const EvaluationSettings& evaluation, const ConstraintSettings& constraints,
                      const std::function<void(double)>& poll = {});

}  // namespace periplus::nbv
