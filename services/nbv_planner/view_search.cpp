#include "services/nbv_planner/view_search.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "common/core/error.h"
#include "services/nbv_planner/search_frame.h"

namespace periplus::nbv {

void check(const SearchSettings& s) {
  require(s.max_evaluations >= 8, ErrorCode::bad_input, "a search takes at least 8 evaluations");
  require(s.time_limit_s >= 0, ErrorCode::bad_input, "a search's time limit is 0 (none) or a number of seconds");
  check(s.fast);
  check(s.thorough);
  check(s.thesis);
  s.lookahead.check();
}

namespace {

constexpr double kNearlyUsedUp = 0.1;    // value of the best view, as a share of the free unknown faces
constexpr double kOutweighed = 0.1;       // of the best view's value where all unknown voxels count

PlannedView search_by_method(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& search, TaskRunner& runner,
                             const std::function<void(double)>& poll) {
  if (search.method == SearchMethod::thesis) return thesis_search(evaluator, seed, search, runner, poll);
  return panorama_search(evaluator, seed, search, search.method == SearchMethod::fast ? search.fast : search.thorough, runner, poll);
}

// What is reported of a view that was judged by likely surface: N_u of all that is unknown.
void tell_all(const Evaluator& evaluator, PlannedView& view) {
  Evaluator::Workspace workspace;
  view.evaluation = evaluator.evaluate(view.X_WC, workspace, Detail::every_term);
  view.terms = evaluator.terms(view.evaluation, view.gain_scale);
  for (auto& [name, value] : view.terms) {
    if (name == "f_e") value = view.f_e;
  }
}

// The best candidates, some distance apart, judged by what the views after each can still add.
void choose_ahead(const Evaluator& evaluator, const SearchSettings& search, PlannedView& view) {
  constexpr double kAheadApart = 0.15, kTurned = 0.25;  // [m], [rad]
  std::vector<ViewCandidate> sorted = view.candidates;
  std::stable_sort(sorted.begin(), sorted.end(), [](const ViewCandidate& a, const ViewCandidate& b) { return a.f_e < b.f_e; });
  sorted.insert(sorted.begin(), {view.X_WC, view.f_e, ""});
  const Bounds left_out = search.method != SearchMethod::thesis                                    ? Bounds::all
                          : view.f_e == evaluator.score(view.evaluation, view.gain_scale) ? Bounds::none
                                                                                           : Bounds::intervals;
  std::vector<ViewPromise> promises;
  std::vector<Candidate> chosen;
  Evaluator::Workspace workspace;
  for (const ViewCandidate& c : sorted) {
    if (static_cast<int>(chosen.size()) == search.lookahead.candidates) break;
    const bool close = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& o) {
      return position_distance(o.X_WC, c.X_WC) < kAheadApart && angle_between(o.X_WC, c.X_WC) < kTurned;
    });
    if (close) continue;
    const Candidate candidate{c.X_WC, evaluator.evaluate(c.X_WC, workspace)};
    if (candidate.evaluation.violation != Violation::none || !(candidate.evaluation.value > 0)) continue;
    ViewPromise promise;
    promise.value = -bounded_score(evaluator, candidate.evaluation, view.gain_scale, left_out);
    for (const voxel::VoxelPixels& v : workspace.visibility.both) {
      if (static_cast<int>(v.pixels) > evaluator.settings().pair.more_than_pixels) promise.voxels.push_back(v.voxel);
    }
    promises.push_back(std::move(promise));
    chosen.push_back(candidate);
  }
  view.evaluations += static_cast<int>(chosen.size());
  if (chosen.size() < 2) return;
  const auto first = static_cast<std::size_t>(look_ahead(promises, evaluator.weights(), search.lookahead).first);
  if (first == 0) return;
  view.X_WC = chosen[first].X_WC;
  view.evaluation = chosen[first].evaluation;
  view.f_e = -promises[first].value;
  view.terms = evaluator.terms(view.evaluation, view.gain_scale);
  for (auto& [name, value] : view.terms) {
    if (name == "f_e") value = view.f_e;
  }
}

}  // namespace

ListedView choose_view(const Evaluator& evaluator, const std::vector<Pose>& poses, Evaluator::Workspace& workspace) {
  require(!poses.empty(), ErrorCode::bad_input, "choosing a view from a list needs at least one pose");
  ListedView best, other;
  int most = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const ListedView view{static_cast<int>(i), evaluator.evaluate(poses[i], workspace)};
    if (best.index < 0 || view.evaluation.value > best.evaluation.value) best = view;
  }
  if (evaluator.everything_counts()) return best;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const voxel::PairGain gain = evaluator.whole().evaluate_pair(poses[i], evaluator.situation().rig, evaluator.settings().pair, workspace.visibility);
    if (other.index >= 0 && gain.voxels <= most) continue;
    most = gain.voxels;
    other.index = static_cast<int>(i);
  }
  if (best.evaluation.value >= kOutweighed * most) return best;
  other.evaluation = evaluator.evaluate(poses[static_cast<std::size_t>(other.index)], workspace);
  return other;
}

PlannedView plan_view(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& settings, TaskRunner& runner,
                      const std::function<void(double)>& poll) {
  check(settings);
  SearchSettings search = settings;
  const bool ahead = search.lookahead.depth > 1 && evaluator.settings().quantification != Quantification::pixels;
  search.keep_candidates |= ahead;
  PlannedView view = search_by_method(evaluator, seed, search, runner, poll);
  const Evaluator* judge = &evaluator;
  std::optional<Evaluator> everything;
  if (!evaluator.everything_counts() && !view.cut_short &&
      view.evaluation.value < kNearlyUsedUp * static_cast<double>(evaluator.whole().unknown_face_count())) {
    // Hardly anything is left where surface is likely: perhaps much is left elsewhere.
    EvaluationSettings all = evaluator.settings();
    all.likely_within = 0;
    everything.emplace(evaluator.situation(), all, evaluator.constraints().settings());
    PlannedView other = search_by_method(*everything, seed, search, runner, poll);
    const int evaluations = view.evaluations + other.evaluations;
    if (view.evaluation.value < kOutweighed * other.evaluation.value) {
      view = std::move(other);
      judge = &*everything;
    }
    view.evaluations = evaluations;
  }
  if (ahead && !view.cut_short) choose_ahead(*judge, search, view);
  if (!settings.keep_candidates) view.candidates.clear();
  if (!judge->everything_counts()) tell_all(*judge, view);
  const std::size_t left = evaluator.whole().unknown_face_count();
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
