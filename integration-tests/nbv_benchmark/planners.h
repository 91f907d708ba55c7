// Who decides where to look next. All planners of a run are given the same situation and the same candidate poses.
//
//   ours     the planner's own value of a view (services/nbv_planner, Evaluator)
//   search   ours, without the list: plan_view over all positions and orientations; not for the dome, which is a list
//   occlusion_aware, unobserved, ...  the gains of the literature (services/nbv_planner/gain.h)
//   random   any of the poses
//   oracle   knows the object: the pose whose depth map covers most samples that are not covered yet
//
// `ours:NAME` and `search:NAME` are the first two with the parameters of the variant NAME (BenchmarkOptions::variants).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/core/random.h"
#include "integration-tests/nbv_benchmark/arena.h"
#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/gain.h"
#include "services/nbv_planner/lookahead.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv_benchmark {

struct PlanningInput {
  const Arena& arena;
  const nbv::Situation& situation;
  const nbv::Evaluator& evaluator;
  const std::vector<int>& eligible;   // candidates that satisfy the constraints and were not taken yet; never empty
  const std::vector<Mask>& covers;    // by candidate: samples that its ideal depth map covers (for the oracle alone)
  const Mask& covered;                // samples covered so far (for the oracle alone)
  std::vector<Pose> taken;            // views so far
  int views_left = 1;                 // this one included
};

struct Choice {
  int candidate = -1;                 // -1: a pose of its own
  Pose X_WC = Pose::Identity();
  double predicted = 0;               // in the planner's own unit
};

class Planner {
 public:
  virtual ~Planner() = default;
  virtual Choice choose(const PlanningInput& input) = 0;
};

struct PlannerSettings {
  nbv::SearchSettings search;
  nbv::EvaluationSettings evaluation;
  nbv::GainSettings gain;
  std::uint64_t seed = 1;
};

// All names but those with a variant, in the order of the tables.
std::vector<std::string> planner_names();
// "ours" and "ahead" of "ours:ahead"; without a variant the name itself and "".
std::string base_of(const std::string& planner);
std::string variant_of(const std::string& planner);
// Throws Error(bad_input) naming the planners that there are.
std::unique_ptr<Planner> make_planner(const std::string& name, const PlannerSettings& settings);
// True for a gain of the literature.
bool literature(const std::string& planner);
// True if the planner needs PlanningInput::covers.
bool knows_the_object(const std::string& planner);
// False for a planner that cannot choose from a list alone.
bool takes_lists(const std::string& planner);

}  // namespace periplus::nbv_benchmark
