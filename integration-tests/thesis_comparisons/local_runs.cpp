#include "integration-tests/thesis_comparisons/local_runs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace periplus::thesis_comparisons {
namespace {

constexpr double kWorthwhile = 1e-6;  // a run that improves by less was the last ("not better than the last starting one")
constexpr double kFar = 20;           // bound of what has none, from the start

LocalOutcome judged(const State& state, const Pose& X_WC, const nbv::Evaluation& e) {
  LocalOutcome o;
  o.X_WC = X_WC;
  o.evaluation = e;
  o.f_e = state.evaluator->score(e, state.greatest);
  o.f_free = o.f_e - state.evaluator->lambdas(state.greatest).interval * (e.k_height + e.k_pitch + e.k_roll);
  const robot::ViewLimits& l = state.situation.limits;
  const Eigen::Vector3d ypr = camera_yaw_pitch_roll(X_WC);
  const double z = X_WC.translation().z(), slack = 1e-9;
  o.within = z >= l.height_min - slack && z <= l.height_max + slack && ypr.y() >= l.pitch_min - slack && ypr.y() <= l.pitch_max + slack &&
             std::abs(ypr.z()) <= l.roll_max + slack;
  return o;
}

}  // namespace

int LocalOutcome::evaluations_to(double slack) const {
  for (const auto& [number, value] : course) {
    if (value <= course.back().second + slack) return number;
  }
  return evaluations;
}

LocalOutcome outcome_of(const State& state, const Pose& X_WC, nbv::Evaluator::Workspace& workspace) {
  return judged(state, X_WC, state.evaluator->evaluate(X_WC, workspace));
}

LocalOutcome search_locally(const State& state, const Pose& start, const LocalOptions& options, nbv::Evaluator::Workspace& workspace) {
  const robot::ViewLimits& l = state.situation.limits;
  const bool bounded = options.method != nbv::LocalMethod::newuoa;
  const auto value_of = [&](const LocalOutcome& o) { return bounded ? o.f_free : o.f_e; };
  LocalOutcome at = outcome_of(state, start, workspace);
  int evaluations = 0, runs = 0, asked = 0;
  std::vector<std::pair<int, double>> course{{0, value_of(at)}};
  while (runs < options.runs && evaluations < options.evaluations) {
    const LocalOutcome from = at;
    const Eigen::Vector3d p = from.X_WC.translation(), ypr = camera_yaw_pitch_roll(from.X_WC);
    const auto f = [&](const std::vector<double>& x) {
      const LocalOutcome o = outcome_of(state, look_along(p + Eigen::Vector3d(x[0], x[1], x[2]), ypr.x() + x[3], ypr.y() + x[4], ypr.z() + x[5]), workspace);
      ++asked;
      if (value_of(o) < value_of(at)) {
        at = o;
        course.emplace_back(asked, value_of(o));
      }
      return value_of(o);
    };
    nbv::LocalSearchOptions o;
    o.method = options.method;
    o.lower = {-kFar, -kFar, l.height_min - p.z(), -kFar, l.pitch_min - ypr.y(), -l.roll_max - ypr.z()};
    o.upper = {kFar, kFar, l.height_max - p.z(), kFar, l.pitch_max - ypr.y(), l.roll_max - ypr.z()};
    o.end = options.rho_end;
    o.max_evaluations = std::min(options.run_evaluations, options.evaluations - evaluations);
    for (std::size_t i = 0; i < 6; ++i) {
      // BOBYQA takes a region that fits into the bounds.
      o.step.push_back(bounded ? std::min(options.rho_beg, 0.49 * (o.upper[i] - o.lower[i])) : options.rho_beg);
    }
    evaluations += nbv::minimize(f, std::vector<double>(6, 0.0), o).evaluations;
    ++runs;
    if (value_of(from) - value_of(at) < kWorthwhile) break;
  }
  at.runs = runs;
  at.evaluations = evaluations;
  at.course = std::move(course);
  return at;
}

}  // namespace periplus::thesis_comparisons
