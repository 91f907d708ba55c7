#include "services/nbv_planner/view_search.h"

#include <chrono>
#include <optional>
#include <string>

#include "common/core/error.h"

namespace periplus::nbv {

void check(const SearchSettings& s) {
  require(s.max_evaluations >= 8, ErrorCode::bad_input, "a search takes at least 8 evaluations");
  require(s.time_limit_s >= 0, ErrorCode::bad_input, "a search's time limit is 0 (none) or a number of seconds");
  check(s.fast);
  check(s.thorough);
  check(s.thesis);
}

PlannedView plan_view(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& search, TaskRunner& runner,
                      const std::function<void(double)>& poll) {
  check(search);
  const PlannedView view = search.method == SearchMethod::thesis ? thesis_search(evaluator, seed, search, runner, poll)
                           : search.method == SearchMethod::fast ? panorama_search(evaluator, seed, search, search.fast, runner, poll)
                                                                 : panorama_search(evaluator, seed, search, search.thorough, runner, poll);
  const std::size_t left = evaluator.visibility().unknown_face_count();
  if (view.evaluation.gain.voxels == 0 && left > 0 && !view.cut_short) {
    throw_error(ErrorCode::nbv_no_reachable_view,
                "unknown voxels are left (" + std::to_string(left) +
                    " free faces), but no view that the constraints allow shows one: end the run, or widen the height, pitch and "
                    "distance limits, remove obstacles, or allow forbidden poses (" +
                    std::to_string(evaluator.situation().forbidden.size()) + ")");
  }
  return view;
}

PlannedView plan_view(const Situation& situation, std::uint64_t seed, const SearchSettings& search,
                      const EvaluationSettings& evaluation, const ConstraintSettings& constraints,
                      const std::function<void(double)>& poll) {
  std::optional<ThreadRunner::Clock::time_point> deadline;
  if (search.time_limit_s > 0) {
    deadline = ThreadRunner::Clock::now() + std::chrono::duration_cast<ThreadRunner::Clock::duration>(std::chrono::duration<double>(search.time_limit_s));
  }
  const Evaluator evaluator(situation, evaluation, constraints);
  ThreadRunner runner(search.threads, deadline);
  return plan_view(evaluator, seed, search, runner, poll);
}

}  // namespace periplus::nbv
