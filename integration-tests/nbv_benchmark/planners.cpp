#include "integration-tests/nbv_benchmark/planners.h"

#include <algorithm>

#include "common/core/error.h"

namespace periplus::nbv_benchmark {
namespace {

// The first of the eligible candidates with the greatest value.
template <class Value>
Choice best(const PlanningInput& in, Value value) {
  Choice choice;
  for (const int i : in.eligible) {
    const double v = value(i);
    if (choice.candidate >= 0 && !(v > choice.predicted)) continue;
    choice.candidate = i;
    choice.predicted = v;
  }
  choice.X_WC = in.arena.candidates[static_cast<std::size_t>(choice.candidate)];
  return choice;
}

class Ours : public Planner {
 public:
  explicit Ours(const nbv::LookaheadSettings& lookahead) : lookahead_(lookahead) {}
  Choice choose(const PlanningInput& in) override {
    std::vector<Pose> poses;
    for (const int i : in.eligible) poses.push_back(in.arena.candidates[static_cast<std::size_t>(i)]);
    const nbv::ListedView view = nbv::choose_view(in.evaluator, poses, workspace_);
    const auto at = [&](std::size_t i) { return Choice{in.eligible[i], poses[i], 0}; };
    Choice choice = at(static_cast<std::size_t>(view.index));
    choice.predicted = view.evaluation.value;
    nbv::LookaheadSettings ahead = lookahead_;
    ahead.depth = std::min(ahead.depth, in.views_left);
    if (ahead.depth == 1) return choice;
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < poses.size(); ++i) order.emplace_back(-in.evaluator.evaluate(poses[i], workspace_).value, i);
    std::sort(order.begin(), order.end());
    if (order[0].second != static_cast<std::size_t>(view.index)) return choice;  // chosen by all that is unknown
    order.resize(std::min(order.size(), static_cast<std::size_t>(ahead.candidates)));
    std::vector<nbv::ViewPromise> promises;
    for (const auto& [negative, i] : order) {
      in.evaluator.evaluate(poses[i], workspace_);
      nbv::ViewPromise promise{-negative, {}};
      for (const voxel::VoxelPixels& v : workspace_.visibility.both)
        if (static_cast<int>(v.pixels) > in.evaluator.settings().pair.more_than_pixels) promise.voxels.push_back(v.voxel);
      promises.push_back(std::move(promise));
    }
    const auto& [negative, i] = order[static_cast<std::size_t>(nbv::look_ahead(promises, in.evaluator.weights(), ahead).first)];
    choice = at(i);
    choice.predicted = -negative;
    return choice;
  }

 private:
  nbv::LookaheadSettings lookahead_;
  nbv::Evaluator::Workspace workspace_;
};

class OursSearch : public Planner {
 public:
  explicit OursSearch(const PlannerSettings& settings) : settings_(settings) {}
  Choice choose(const PlanningInput& in) override {
    const nbv::PlannedView v = nbv::plan_view(in.situation, settings_.seed + in.taken.size(), settings_.search, settings_.evaluation, {});
    return {-1, v.X_WC, v.evaluation.value};
  }

 private:
  PlannerSettings settings_;
};

class LiteratureGain : public Planner {
 public:
  LiteratureGain(const std::string& name, const nbv::GainSettings& settings) : name_(name), settings_(settings) {}
  Choice choose(const PlanningInput& in) override {
    const auto gain = nbv::make_information_gain(name_, in.situation, settings_);
    return best(in, [&](int i) { return gain->evaluate(in.arena.candidates[static_cast<std::size_t>(i)]); });
  }

 private:
  std::string name_;
  nbv::GainSettings settings_;
};

class RandomPlanner : public Planner {
 public:
  explicit RandomPlanner(std::uint64_t seed) : random_(seed) {}
  Choice choose(const PlanningInput& in) override {
    const int i = in.eligible[random_.below(in.eligible.size())];
    return {i, in.arena.candidates[static_cast<std::size_t>(i)], 0};
  }

 private:
  Random random_;
};

class Oracle : public Planner {
 public:
  Choice choose(const PlanningInput& in) override {
    return best(in, [&](int i) { return static_cast<double>(in.covers.at(static_cast<std::size_t>(i)).beyond(in.covered)); });
  }
};

}  // namespace

bool literature(const std::string& name) {
  const std::vector<std::string>& names = nbv::information_gain_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> planner_names() {
  std::vector<std::string> names = {"ours", "search"};
  for (const std::string& gain : nbv::information_gain_names()) names.push_back(gain);
  names.insert(names.end(), {"random", "oracle"});
  return names;
}

std::string base_of(const std::string& planner) { return planner.substr(0, planner.find(':')); }
std::string variant_of(const std::string& planner) {
  const std::size_t colon = planner.find(':');
  return colon == std::string::npos ? "" : planner.substr(colon + 1);
}

bool knows_the_object(const std::string& planner) { return planner == "oracle"; }
bool takes_lists(const std::string& planner) { return base_of(planner) != "search"; }

std::unique_ptr<Planner> make_planner(const std::string& name, const PlannerSettings& settings) {
  const std::string base = base_of(name);
  if (base == "ours") return std::make_unique<Ours>(settings.search.lookahead);
  if (base == "search") return std::make_unique<OursSearch>(settings);
  if (name == "random") return std::make_unique<RandomPlanner>(settings.seed);
  if (name == "oracle") return std::make_unique<Oracle>();
  if (literature(name)) return std::make_unique<LiteratureGain>(name, settings.gain);
  std::string known;
  for (const std::string& n : planner_names()) known += " " + n;
  throw_error(ErrorCode::bad_input, "there is no planner '" + name + "'; there are:" + known);
}

}  // namespace periplus::nbv_benchmark
