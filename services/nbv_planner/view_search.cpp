#include "services/nbv_planner/view_search.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/core/error.h"
#include "common/core/random.h"
#include "services/nbv_planner/line_of_sight.h"
#include "services/nbv_planner/local_search.h"
#include "services/nbv_planner/orientation.h"

namespace periplus::nbv {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kDrawsPerSample = 200;
constexpr double kFarthestDraw = 2.3;   // from the face or the box [m]
constexpr double kInnerHeights = 0.75;  // of the height range: nearer to its bounds Kz costs more than is to be won
constexpr double kWorthwhile = 0.5;     // a run that improves f_e by less was the last

// Looked around from before time may run out: somewhere there is a view then.
constexpr int kLeastPlaces = 16;

struct Candidate {
  Pose X_WC = Pose::Identity();
  Evaluation evaluation;
};
template <class Fields>
void visit_fields(Fields& fields, Candidate& c) {
  fields(c.X_WC, c.evaluation);
}

// What became of a start.
struct Refined {
  Candidate end;
  std::optional<Candidate> best;  // feasible, of all that were evaluated on the way
  int evaluations = 0;
};
template <class Fields>
void visit_fields(Fields& fields, Refined& r) {
  fields(r.end, r.best, r.evaluations);
}

// A place that was drawn, with its best orientation if there is a feasible one.
struct Place {
  std::optional<Sample> sample;
};
template <class Fields>
void visit_fields(Fields& fields, Place& p) {
  fields(p.sample);
}

double position_distance(const Pose& a, const Pose& b) { return (a.translation() - b.translation()).norm(); }

class Search {
 public:
  Search(const Situation& situation, std::uint64_t seed, const SearchSettings& settings, const Evaluator& evaluator,
         TaskRunner& runner, const std::function<void(double)>& poll)
      : s_(situation), seed_(seed), settings_(settings), evaluator_(evaluator), runner_(runner), poll_(poll) {
    workspaces_.resize(runner.workers());
  }

  PlannedView run();

 private:
  void progress(double share) const {
    if (poll_) poll_(share);
  }
  void finish_stage(const char* name) {
    const auto now = std::chrono::steady_clock::now();
    result_.seconds.emplace_back(name, std::chrono::duration<double>(now - stage_start_).count());
    stage_start_ = now;
  }

  double f(const Evaluation& e) const { return evaluator_.score(e, gain_scale_); }
  // Feasible and with gain before feasible without, then by f_e.
  bool better(const Candidate& a, const Candidate& b) const {
    const bool gain_a = a.evaluation.value > 0, gain_b = b.evaluation.value > 0;
    if (gain_a != gain_b) return gain_a;
    return f(a.evaluation) < f(b.evaluation);
  }
  void offer(const Candidate& c, std::optional<Candidate>& best) const {
    if (c.evaluation.violation != Violation::none) return;
    if (!best || better(c, *best)) best = c;
  }

  std::optional<Eigen::Vector3d> draw_place(int i, Random& random) const;
  std::vector<Sample> look_around_places(int count);
  std::vector<Candidate> evaluate_samples(const std::vector<Sample>& samples, int count);
  // The first `count` of `sorted`, at least `apart` from each other [m].
  static std::vector<Candidate> spread(const std::vector<Candidate>& sorted, int count, double apart);
  // Runs of BOBYQA from `start`, at most `budget` evaluations.
  Refined refine(const Candidate& start, int runs, int budget, Evaluator::Workspace& workspace) const;
  std::vector<Candidate> stage(const std::vector<Candidate>& starts, int runs, int budget_each);

  const Situation& s_;
  std::uint64_t seed_;
  SearchSettings settings_;
  const Evaluator& evaluator_;
  TaskRunner& runner_;
  const std::function<void(double)>& poll_;
  std::vector<Evaluator::Workspace> workspaces_;
  std::vector<voxel::VisibilityScene::Face> faces_;
  double gain_scale_ = 1;
  std::optional<Candidate> best_;
  PlannedView result_;
  std::chrono::steady_clock::time_point stage_start_ = std::chrono::steady_clock::now();
};

std::optional<Eigen::Vector3d> Search::draw_place(int i, Random& random) const {
  const voxel::GridGeometry& g = evaluator_.visibility().geometry();
  const Eigen::Vector3d half = g.size.cast<double>() * g.voxel_size / 2;
  const Eigen::Vector3d middle = g.X_WG * half;
  const robot::ViewLimits& l = s_.limits;
  const double farthest = std::max(l.distance_min, std::min(l.distance_max, kFarthestDraw));
  const double height = (l.height_min + l.height_max) / 2, reach = (l.height_max - l.height_min) / 2 * kInnerHeights;
  for (int draw = 0; draw < kDrawsPerSample; ++draw) {
    // Many of the best views lie at the bounds of the height: draw wider and clamp.
    const double z = height + std::clamp(random.uniform(-1.6, 1.6), -1.0, 1.0) * reach;
    const double angle = random.uniform(-kPi, kPi);
    // Uniform in the distance: the density over the floor falls with it (thesis 3.3.2).
    const double distance = random.uniform(l.distance_min, farthest);
    Eigen::Vector3d from = middle;
    Eigen::Vector3d p;
    if (!faces_.empty() && i % 4 != 3) {
      const auto& face = faces_[random.below(faces_.size())];
      from = g.center_world(evaluator_.visibility().voxel(face.voxel));
      p = {from.x() + distance * std::cos(angle), from.y() + distance * std::sin(angle), z};
      const double sign = face.direction % 2 == 0 ? -1 : 1;
      const Eigen::Vector3d outward = sign * g.X_WG.linear().col(face.direction / 2);
      if (outward.dot(p - from) < 0.15 * distance) continue;
      // Places from which the face is hidden are of little use; where there seem to be no others they must do.
      if (draw < kDrawsPerSample / 2 && !in_sight(s_, p, from + 0.51 * g.voxel_size * outward)) continue;
    } else {
      const double radius = distance + std::hypot(half.x(), half.y()) * random.uniform();
      p = {middle.x() + radius * std::cos(angle), middle.y() + radius * std::sin(angle), z};
    }
    const double yaw = std::atan2(from.y() - p.y(), from.x() - p.x());
    if (evaluator_.constraints().check_position(p, yaw) == Violation::none) return p;
  }
  return std::nullopt;
}

std::vector<Sample> Search::look_around_places(int count) {
  std::vector<Sample> samples;
  // With time out before anything feasible was found, on it goes: that no place is reachable must be true when it is said.
  for (int begun = 0; samples.empty() && begun < count;) {
    const auto drawn = runner_.map<Place>(
        count - begun,
        [&](int i, int worker) {
          Random random(seed_ + 0x632be59bd9b4e019ULL * static_cast<std::uint64_t>(begun + i + 1));
          Place place;
          const auto p = draw_place(begun + i, random);
          if (!p) return place;
          const Sample sample = look_around(evaluator_, *p, workspaces_[worker].visibility);
          if (evaluator_.constraints().check(sample.X_WC) == Violation::none) place.sample = sample;
          return place;
        },
        kLeastPlaces);
    for (const auto& place : drawn) {
      if (!place) continue;
      ++begun;
      if (place->sample) samples.push_back(*place->sample);
    }
    result_.evaluations = begun;
  }
  return samples;
}

std::vector<Candidate> Search::evaluate_samples(const std::vector<Sample>& samples, int count) {
  // What the list of visible voxels promises, with the penalties that need no rendering.
  int most = 1;
  for (const Sample& sample : samples) most = std::max(most, sample.voxels);
  std::vector<std::pair<double, int>> order;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double z = samples[i].X_WC.translation().z(), pitch = camera_yaw_pitch_roll(samples[i].X_WC).y();
    const robot::ViewLimits& l = s_.limits;
    const auto share = [&](double v, double low, double high) {
      return std::pow((2 * v - low - high) / (high - low), evaluator_.settings().interval_exponent);
    };
    double promise = samples[i].voxels - most * (share(z, l.height_min, l.height_max) + share(pitch, l.pitch_min, l.pitch_max));
    if (evaluator_.landmark_term()) {
      promise -= evaluator_.settings().lambda_landmarks * evaluator_.landmark_penalty(samples[i].landmarks);
    }
    order.emplace_back(-promise, static_cast<int>(i));
  }
  std::sort(order.begin(), order.end());
  std::vector<Candidate> chosen;
  for (const auto& [promise, i] : order) {
    const Pose& X = samples[i].X_WC;
    const bool close = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& c) {
      return position_distance(c.X_WC, X) < 0.08 && angle_between(c.X_WC, X) < 0.1;
    });
    if (!close) chosen.push_back({X, {}});
    if (static_cast<int>(chosen.size()) >= count) break;
  }
  const auto evaluated = runner_.map<Candidate>(
      static_cast<int>(chosen.size()),
      [&](int i, int worker) {
        return Candidate{chosen[i].X_WC, evaluator_.evaluate(chosen[i].X_WC, workspaces_[worker])};
      },
      1);
  std::vector<Candidate> candidates;
  for (const auto& c : evaluated) {
    if (c) candidates.push_back(*c);
  }
  result_.evaluations += static_cast<int>(candidates.size());
  return candidates;
}

std::vector<Candidate> Search::spread(const std::vector<Candidate>& sorted, int count, double apart) {
  std::vector<Candidate> chosen;
  for (const Candidate& c : sorted) {
    if (static_cast<int>(chosen.size()) >= count) break;
    const bool close = std::any_of(chosen.begin(), chosen.end(),
                                   [&](const Candidate& o) { return position_distance(o.X_WC, c.X_WC) < apart; });
    if (!close) chosen.push_back(c);
  }
  return chosen;
}

Refined Search::refine(const Candidate& start, int runs, int budget, Evaluator::Workspace& workspace) const {
  const robot::ViewLimits& l = s_.limits;
  const double voxel = evaluator_.visibility().geometry().voxel_size;
  Refined refined;
  Candidate& at = refined.end = start;
  for (int run = 0; run < runs && budget > 0 && !runner_.out_of_time(); ++run) {
    const Pose X_start = at.X_WC;
    const double nearest = evaluator_.constraints().nearest_voxel(X_start.translation());
    const double distance = std::isfinite(nearest) ? std::clamp(nearest, 0.3, 3.0) : 1.0;
    const double region = std::clamp(settings_.trust_region * voxel * distance, 5 * settings_.end, 0.4);
    // Yaw and pitch are those towards a point at the object's distance on the axis, plus the variables: moving the
    // camera then turns it around the object, and the variables' effects hardly mix.
    const Eigen::Vector3d focus = X_start * Eigen::Vector3d(0, 0, distance + 0.1);
    const auto pose_of = [&](const std::vector<double>& x) {
      const Eigen::Vector3d p = X_start.translation() + Eigen::Vector3d(x[0], x[1], x[2]);
      const Eigen::Vector3d d = focus - p;
      const double pitch = std::atan2(-d.z(), std::hypot(d.x(), d.y())) + x[4] / distance;
      return look_along(p, std::atan2(d.y(), d.x()) + x[3] / distance, std::clamp(pitch, l.pitch_min, l.pitch_max));
    };
    const double before = f(at.evaluation);
    const auto value = [&](const std::vector<double>& x) {
      Candidate c{pose_of(x), {}};
      c.evaluation = evaluator_.evaluate(c.X_WC, workspace);
      offer(c, refined.best);
      const double score = f(c.evaluation);
      if (score < f(at.evaluation)) at = c;
      return score;
    };
    const double z = X_start.translation().z();
    LocalSearchOptions options;
    options.step = {region, region, region / 2, region, region};
    options.lower = {-2, -2, l.height_min - z, -1, -1};
    options.upper = {2, 2, l.height_max - z, 1, 1};
    options.end = settings_.end;
    options.max_evaluations = std::min(settings_.run_evaluations, budget);
    const LocalSearchResult found = minimize(value, {0, 0, 0, 0, 0}, options);
    budget -= found.evaluations;
    refined.evaluations += found.evaluations;
    if (before - f(at.evaluation) < kWorthwhile) break;
  }
  return refined;
}

std::vector<Candidate> Search::stage(const std::vector<Candidate>& starts, int runs, int budget_each) {
  const auto refined = runner_.map<Refined>(static_cast<int>(starts.size()), [&](int i, int worker) {
    return refine(starts[i], runs, budget_each, workspaces_[worker]);
  });
  std::vector<Candidate> ends;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    ends.push_back(refined[i] ? refined[i]->end : starts[i]);
    if (!refined[i]) continue;
    if (refined[i]->best) offer(*refined[i]->best, best_);
    result_.evaluations += refined[i]->evaluations;
  }
  std::stable_sort(ends.begin(), ends.end(),
                   [&](const Candidate& a, const Candidate& b) { return f(a.evaluation) < f(b.evaluation); });
  return ends;
}

PlannedView Search::run() {
  const std::size_t faces = evaluator_.visibility().unknown_face_count();
  faces_ = evaluator_.visibility().unknown_faces(std::max<std::size_t>(1, faces / 4096));
  const int budget = std::max(settings_.max_evaluations, 8);
  const int sample_count = std::clamp(settings_.samples, 1, std::max(4, budget / 3));
  std::vector<Sample> samples = look_around_places(sample_count);
  if (samples.empty()) {
    throw_error(ErrorCode::nbv_no_reachable_view,
                "no place around the object satisfies the view's constraints: check the height, pitch and distance "
                "limits, the obstacles around the object, and the forbidden poses (" +
                    std::to_string(s_.forbidden.size()) + ")");
  }
  finish_stage("sampling");
  progress(0.3);

  std::vector<Candidate> candidates =
      evaluate_samples(samples, std::clamp(settings_.detailed, 1, std::max(2, budget / 8)));
  for (const Candidate& c : candidates) gain_scale_ = std::max(gain_scale_, c.evaluation.value);
  for (const Candidate& c : candidates) offer(c, best_);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const Candidate& a, const Candidate& b) { return f(a.evaluation) < f(b.evaluation); });
  finish_stage("detail");
  progress(0.4);

  if (faces > 0) {
    const int left = budget - result_.evaluations;
    const auto starts = spread(candidates, std::max(1, settings_.starts), 0.15);
    auto ends = stage(starts, settings_.first_stage_runs, left * 2 / 3 / static_cast<int>(starts.size()));
    finish_stage("first stage");
    progress(0.8);
    const auto finalists = spread(ends, std::max(1, settings_.finalists), 0.05);
    stage(finalists, settings_.second_stage_runs, (budget - result_.evaluations) / static_cast<int>(finalists.size()));
    finish_stage("second stage");
  }
  // Every candidate was checked when it was evaluated; this is the last word before the robot goes there.
  PERIPLUS_ASSERT(best_.has_value() && evaluator_.constraints().check(best_->X_WC) == Violation::none);
  progress(1);
  result_.X_WC = best_->X_WC;
  result_.evaluation = best_->evaluation;
  result_.f_e = f(best_->evaluation);
  result_.gain_scale = gain_scale_;
  result_.landmark_term = evaluator_.landmark_term();
  result_.cut_short = runner_.out_of_time();
  result_.terms = evaluator_.terms(best_->evaluation, gain_scale_);
  return result_;
}

}  // namespace

PlannedView plan_view(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& search, TaskRunner& runner,
                      const std::function<void(double)>& poll) {
  const PlannedView view = Search(evaluator.situation(), seed, search, evaluator, runner, poll).run();
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
  const Evaluator evaluator(situation, evaluation, constraints);
  ThreadRunner runner(search.threads);
  return plan_view(evaluator, seed, search, runner, poll);
}

}  // namespace periplus::nbv
