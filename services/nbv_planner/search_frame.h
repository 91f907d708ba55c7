// What every search needs: where places are drawn, which candidate is the better one, the count of evaluations, the stages.
// Used by thesis_search and panorama_search.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <vector>

#include "common/core/random.h"
#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/task_runner.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv {

// A pose that was evaluated exactly.
struct Candidate {
  Pose X_WC = Pose::Identity();
  Evaluation evaluation;
};
template <class Fields>
void visit_fields(Fields& fields, Candidate& c) {
  fields(c.X_WC, c.evaluation);
}

// The terms of 3.15 that a search leaves out of f_e because it keeps their limits as bounds: next to a bound they cost what is
// to be won there (3.4.4).
enum class Bounds {
  none,       // f_e is whole
  intervals,  // height, roll, pitch and yaw
  all,        // the distances too
};
double bounded_score(const Evaluator& evaluator, const Evaluation& evaluation, double greatest, Bounds bounds);

// How places are drawn: as the thesis does (3.3.2), uniformly in the distance, so that their density over the floor falls with it.
struct PlaceSampling {
  double height_share = 1;  // of the height range that heights are drawn from, widened and clamped
  double nearness = 1;      // exponent of what distances are drawn from: above 1 nearer than uniformly
  bool ordered = false;     // free faces in turn, evenly over the surface, and places too near moved back (move_back)
};

double position_distance(const Pose& a, const Pose& b);

class SearchFrame {
 public:
  SearchFrame(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& settings, TaskRunner& runner, Bounds bounds,
              const std::function<void(double)>& poll);

  const Evaluator& evaluator;
  const Situation& situation;
  const SearchSettings& settings;
  TaskRunner& runner;
  const Bounds bounds;
  std::vector<Evaluator::Workspace> workspaces;  // by worker
  std::vector<voxel::VisibilityScene::Face> faces;  // some thousands of free faces of unknown voxels
  double greatest = 1;                           // the largest value met among the samples: scale of penalties

  // Random numbers of task i of a stage, whoever runs it.
  Random random(int stage, int i) const;
  double score(const Evaluation& e) const;
  // Those with gain first, then by score.
  bool better(const Candidate& a, const Candidate& b) const;
  // Takes it as the best so far if it is feasible and better.
  void offer(const Candidate& c, std::optional<Candidate>& best) const;
  void offer(const Candidate& c) { offer(c, best); }
  std::optional<Candidate> best;

  // Left of the budget of evaluations.
  int left() const { return settings.max_evaluations - evaluations; }
  int evaluations = 0;

  // Evaluates poses exactly, as many as the budget lets; those that time did not suffice for are missing.
  std::vector<Candidate> evaluate(const std::vector<Pose>& poses, int at_least = 0);

  void note(const Pose& X_WC, double f_e, const char* stage);
  void end_stage(const char* name, double share_done);
  // The answer is `best`, which must be there.
  PlannedView finish();
  // Error(nbv_no_reachable_view).
  [[noreturn]] void throw_unreachable() const;

  // A place between the eyes, feasible as far as the place alone decides: three quarters on the side that a random free face
  // of an unknown voxel looks to, the others around the object's box, both denser near it. `from`: what it was drawn for.
  struct Place {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero(), from = Eigen::Vector3d::Zero();
  };
  std::optional<Place> draw_place(int i, const PlaceSampling& sampling, Random& random) const;
  // Many of the best views are as near as they may be: a place that is nearer is moved away from where it looks to.
  void move_back(Eigen::Vector3d& p_W, double yaw) const;

 private:
  const voxel::VisibilityScene::Face& face_in_turn(int i) const;

  std::uint64_t seed_;
  const std::function<void(double)>& poll_;
  PlannedView result_;
  std::chrono::steady_clock::time_point stage_start_ = std::chrono::steady_clock::now();
};

}  // namespace periplus::nbv
