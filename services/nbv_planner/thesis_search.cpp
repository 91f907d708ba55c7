#include "services/nbv_planner/thesis_search.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/core/error.h"
#include "services/nbv_planner/local_search.h"
#include "services/nbv_planner/search_frame.h"

namespace periplus::nbv {
namespace {

constexpr double kWorthwhile = 0.5;  // a run that improves f_e by less was the last
constexpr int kLeastSamples = 16;    // evaluated before time may run out: somewhere there is a view then
constexpr double kInnerHeights = 0.75;  // of the height range: nearer to its bounds Kz costs more than is to be won

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

struct Drawn {
  std::optional<Candidate> candidate;
};
template <class Fields>
void visit_fields(Fields& fields, Drawn& d) {
  fields(d.candidate);
}

LocalMethod method_of(ThesisLocal local) {
  return local == ThesisLocal::newuoa ? LocalMethod::newuoa : local == ThesisLocal::nelder_mead ? LocalMethod::nelder_mead : LocalMethod::bobyqa;
}

class ThesisSearch {
 public:
  ThesisSearch(SearchFrame& frame, const ThesisSettings& settings) : frame_(frame), settings_(settings) {}

  PlannedView run() {
    std::vector<Candidate> samples = sample();
    frame_.end_stage("sampling", 0.4);
    if (settings_.local != ThesisLocal::none && !frame_.faces.empty() && !samples.empty()) {
      const auto starts = spread(samples, settings_.starts, 0.15);
      auto ends = stage("first stage", starts, settings_.first_stage_runs, frame_.left() * 2 / 3 / static_cast<int>(starts.size()));
      frame_.end_stage("first stage", 0.8);
      const auto finalists = spread(ends, settings_.finalists, 0.05);
      stage("second stage", finalists, settings_.second_stage_runs, frame_.left() / static_cast<int>(finalists.size()));
      frame_.end_stage("second stage", 1);
    }
    return frame_.finish();
  }

 private:
  // Poses that look at what they were drawn for, best first. Throws if none is feasible.
  std::vector<Candidate> sample() {
    const int count = settings_.local == ThesisLocal::none ? frame_.left() : std::clamp(settings_.samples, 1, std::max(4, frame_.left() / 3));
    std::vector<Candidate> samples;
    // With time out before anything feasible was found, on it goes: that no place is reachable must be true when it is said.
    for (int begun = 0; samples.empty() && begun < count;) {
      const auto drawn = frame_.runner.map<Drawn>(
          count - begun, [&](int i, int worker) { return draw(begun + i, frame_.workspaces[worker]); }, kLeastSamples);
      for (const auto& d : drawn) {
        if (!d) continue;
        ++begun;
        if (d->candidate) samples.push_back(*d->candidate);
      }
      frame_.evaluations = begun;
    }
    if (samples.empty()) frame_.throw_unreachable();
    for (const Candidate& c : samples) frame_.greatest = std::max(frame_.greatest, c.evaluation.value);
    for (const Candidate& c : samples) {
      frame_.offer(c);
      frame_.note(c.X_WC, frame_.score(c.evaluation), "sampling");
    }
    sort(samples);
    return samples;
  }

  Drawn draw(int i, Evaluator::Workspace& workspace) const {
    Random random = frame_.random(0, i);
    const Situation& s = frame_.situation;
    Drawn drawn;
    const auto place = frame_.draw_place(i, {.height_share = frame_.bounds != Bounds::none ? 1.0 : kInnerHeights}, random);
    if (!place) return drawn;
    // Towards the face that the place was drawn for, or any point of the box.
    const voxel::GridGeometry& g = frame_.evaluator.visibility().geometry();
    const Eigen::Vector3d side = g.size.cast<double>() * g.voxel_size;
    const Eigen::Vector3d inner = g.X_WG * (side.array() * Eigen::Array3d(random.uniform(), random.uniform(), random.uniform())).matrix();
    const Eigen::Vector3d target = i % 4 != 3 ? Eigen::Vector3d(place->from + (inner - place->from) * random.uniform(0, 0.5)) : inner;
    const Eigen::Vector3d d = target - place->p_W;
    const double pitch = std::clamp(std::atan2(-d.z(), std::hypot(d.x(), d.y())), s.limits.pitch_min, s.limits.pitch_max);
    const double roll = s.limits.roll_max > 0 ? random.uniform(-s.limits.roll_max, s.limits.roll_max) * 0.7 : 0;
    const Pose X_WC = look_along(place->p_W, std::atan2(d.y(), d.x()), pitch, roll) * Pose(Eigen::Translation3d(-s.rig.baseline / 2, 0, 0));
    if (frame_.evaluator.constraints().check(X_WC) != Violation::none) return drawn;
    drawn.candidate = Candidate{X_WC, frame_.evaluator.evaluate(X_WC, workspace)};
    return drawn;
  }

  void sort(std::vector<Candidate>& candidates) const {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [&](const Candidate& a, const Candidate& b) { return frame_.score(a.evaluation) < frame_.score(b.evaluation); });
  }

  // The first `count` of `sorted`, at least `apart` from each other [m].
  static std::vector<Candidate> spread(const std::vector<Candidate>& sorted, int count, double apart) {
    std::vector<Candidate> chosen;
    for (const Candidate& c : sorted) {
      if (static_cast<int>(chosen.size()) >= count) break;
      const bool close = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& o) { return position_distance(o.X_WC, c.X_WC) < apart; });
      if (!close) chosen.push_back(c);
    }
    return chosen;
  }

  // Runs from `start` (3.16), at most `budget` evaluations.
  Refined refine(const Candidate& start, int runs, int budget, Evaluator::Workspace& workspace) const {
    const robot::ViewLimits& l = frame_.situation.limits;
    const double voxel = frame_.evaluator.visibility().geometry().voxel_size;
    const int variables = l.roll_max > 0 ? 6 : 5;
    Refined refined;
    Candidate& at = refined.end = start;
    for (int run = 0; run < runs && budget > 0 && !frame_.runner.out_of_time(); ++run) {
      const Pose X_start = at.X_WC;
      const double nearest = frame_.evaluator.constraints().nearest_voxel(X_start.translation());
      const double distance = std::isfinite(nearest) ? std::clamp(nearest, 0.3, 3.0) : 1.0;
      const double region = std::clamp(settings_.trust_region * voxel * distance, 5 * settings_.end, 0.4);
      // Yaw and pitch are those towards a point at the object's distance on the axis, plus the variables: moving the
      // camera then turns it around the object, and the variables' effects hardly mix.
      const Eigen::Vector3d focus = X_start * Eigen::Vector3d(0, 0, distance + 0.1);
      const double roll = camera_yaw_pitch_roll(X_start).z();
      const auto pose_of = [&](const std::vector<double>& x) {
        const Eigen::Vector3d p = X_start.translation() + Eigen::Vector3d(x[0], x[1], x[2]);
        const Eigen::Vector3d d = focus - p;
        double pitch = std::atan2(-d.z(), std::hypot(d.x(), d.y())) + x[4] / distance;
        if (frame_.bounds != Bounds::none) pitch = std::clamp(pitch, l.pitch_min, l.pitch_max);
        return look_along(p, std::atan2(d.y(), d.x()) + x[3] / distance, pitch, variables == 6 ? roll + x[5] / distance : 0);
      };
      const double before = frame_.score(at.evaluation);
      const auto value = [&](const std::vector<double>& x) {
        Candidate c{pose_of(x), {}};
        c.evaluation = frame_.evaluator.evaluate(c.X_WC, workspace);
        frame_.offer(c, refined.best);
        const double score = frame_.score(c.evaluation);
        if (score < frame_.score(at.evaluation)) at = c;
        return score;
      };
      const double z = X_start.translation().z();
      LocalSearchOptions options;
      options.method = method_of(settings_.local);
      options.step = {region, region, region / 2, region, region};
      options.lower = {-2, -2, l.height_min - z, -1, -1};
      options.upper = {2, 2, l.height_max - z, 1, 1};
      if (variables == 6) {
        options.step.push_back(region);
        options.lower.push_back((-l.roll_max - roll) * distance);
        options.upper.push_back((l.roll_max - roll) * distance);
      }
      options.end = settings_.end;
      options.max_evaluations = std::min(settings_.run_evaluations, budget);
      const LocalSearchResult found = minimize(value, std::vector<double>(variables, 0.0), options);
      budget -= found.evaluations;
      refined.evaluations += found.evaluations;
      if (before - frame_.score(at.evaluation) < kWorthwhile) break;
    }
    return refined;
  }

  std::vector<Candidate> stage(const char* name, const std::vector<Candidate>& starts, int runs, int budget_each) {
    const auto refined = frame_.runner.map<Refined>(static_cast<int>(starts.size()), [&](int i, int worker) {
      return refine(starts[i], runs, budget_each, frame_.workspaces[worker]);
    });
    std::vector<Candidate> ends;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      ends.push_back(refined[i] ? refined[i]->end : starts[i]);
      if (!refined[i]) continue;
      if (refined[i]->best) frame_.offer(*refined[i]->best);
      frame_.evaluations += refined[i]->evaluations;
      frame_.note(refined[i]->end.X_WC, frame_.score(refined[i]->end.evaluation), name);
    }
    sort(ends);
    return ends;
  }

  SearchFrame& frame_;
  const ThesisSettings& settings_;
};

}  // namespace

void check(const ThesisSettings& s) {
  require(s.samples >= 1 && s.starts >= 1 && s.first_stage_runs >= 1 && s.finalists >= 1 && s.second_stage_runs >= 1, ErrorCode::bad_input,
          "the thesis' search takes samples, starts, finalists and runs of at least 1");
  require(s.run_evaluations >= 15 && s.trust_region > 0 && s.end > 0, ErrorCode::bad_input,
          "a run of the thesis' search takes at least 15 evaluations, a trust region and an end above 0");
}

PlannedView thesis_search(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& search, TaskRunner& runner,
                          const std::function<void(double)>& poll) {
  const ThesisLocal local = search.thesis.local;
  const bool bounded = local == ThesisLocal::bobyqa || local == ThesisLocal::nelder_mead;
  SearchFrame frame(evaluator, seed, search, runner, bounded ? Bounds::intervals : Bounds::none, poll);
  return ThesisSearch(frame, search.thesis).run();
}

}  // namespace periplus::nbv
