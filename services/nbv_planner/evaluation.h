// The evaluation function of a viewpoint (thesis 3.2.1): the unknown that it would show, and its constraints as smooth
// penalties.
//
//   f_e = lz Kz + lx Kroll + ly Kpitch + ld Kd + ll Kl + lf Kf - N_u                                        (3.15)
//
// Beyond the thesis stand Kyaw (as Kroll), Kfar (the distance is bounded above too), Kmotion and Kreach, all of which may be
// left out by their factors. In place of N_u stands `value`, which is N_u unless the settings weigh voxels or count pixels.
// World frame, metres, radians; pixels of the rig's camera.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/voxel/visibility.h"
#include "services/nbv_planner/constraints.h"
#include "services/nbv_planner/quality.h"
#include "services/nbv_planner/situation.h"

namespace periplus::nbv {

// What the unknown that both eyes see is worth (thesis 3.1.2).
enum class Quantification {
  pixels,  // its pixels
  voxels,  // its voxels with at least one pixel in each eye
  mixed,   // its voxels with more pixels than the threshold: N_u
};

// The factors of 3.15.
enum class LambdaRule {
  capped,  // intervals: the greatest value; distance, landmarks, forbidden: as given, the last at most the greatest value,
           // since K_f reaches far and late in a run would drive every view away from the little that is left
  scaled,  // 3.2.1.5: all such that a violated constraint costs the greatest value; landmarks: none of them visible
  fixed,   // as given, as in 3.4.7
};

struct EvaluationSettings {
  Quantification quantification = Quantification::mixed;
  // The threshold grows with the voxel: more than this share of the pixels that a voxel's face, seen face on, fills at the
  // far end of the pair's range. Otherwise large voxels reward slivers, seen past an edge or along the surface.
  double pixels_per_voxel_share = 0.2;
  int interval_exponent = 6;        // p of 3.7, even
  double distance_slope = 20;       // gamma of 3.8 [1/m]; r is 1
  int least_landmarks = 5;          // Nl_min of 3.11
  double landmark_reward = 1;       // eta of 3.12
  double landmark_slope = 20;       // beta of 3.10
  double landmark_cosine = 0.5;     // phi of 3.10: seen at up to 60 degrees from its normal
  double forbidden_slope = 1;       // delta of 3.14
  double motion_per_m = 0.2;        // K_motion: per metre that the left eye moves [1/m] ...
  double motion_per_rad = 0.1;      // ... and per radian that it turns
  LambdaRule lambda_rule = LambdaRule::capped;
  int likely_within = 0;            // unknown voxels farther from known ones do not count (likely_surface.h) [voxels]; 0: all do
  double quality_weight = 0;        // of a known voxel that is seen better than so far (quality.h), per unit of quality, in unknown voxels
  double quality_reference = 0.8;   // z_ref: nearer than this a look is no better [m]
  double lambda_interval = 0;       // of height, pitch, roll and yaw where fixed; 0: the greatest value
  double lambda_distance = 100, lambda_landmarks = 1, lambda_forbidden = 1000;
  double lambda_motion = 0, lambda_reach = 0;  // shares of the greatest value
  bool landmarks = true;            // false: never the landmark term
  voxel::PairOptions pair;          // least threshold of N_u and the pair's depth range
};

struct Evaluation {
  voxel::PairGain gain;             // N_u and its pixels; with Detail::search those of the voxels that count
  double value = 0;                 // what the search maximises
  double quality = 0;               // gain in quality of known surface; part of value by its weight
  double k_height = 0, k_roll = 0, k_pitch = 0, k_yaw = 0, k_distance = 0, k_far = 0, k_landmarks = 0, k_forbidden = 0;
  double k_motion = 0, k_reach = 0;
  double visible_landmarks = 0;     // sum of ls ln over the landmarks in view
  double sum_ls = 0, sum_ln = 0;    // 3.9 over the landmarks in view, 3.10 over all; with Detail::every_term alone
  Violation violation = Violation::none;
};
// For task_numbers.h: every field. A new one changes the size and belongs here as well.
template <class Fields>
void visit_fields(Fields& fields, Evaluation& e) {
  static_assert(sizeof(Evaluation) == 144);
  fields(e.gain.voxels, e.gain.pixels, e.value, e.quality, e.k_height, e.k_roll, e.k_pitch, e.k_yaw, e.k_distance, e.k_far, e.k_landmarks,
         e.k_forbidden, e.k_motion, e.k_reach, e.visible_landmarks, e.sum_ls, e.sum_ln, e.violation);
}

enum class Detail {
  search,      // poses that head, body or a forbidden pose rule out are not rendered: N_u is 0
  every_term,  // all terms of any pose, as a map of them needs
};

// Immutable but for the workspaces: may be shared between threads.
class Evaluator {
 public:
  Evaluator(const Situation& situation, const EvaluationSettings& settings, const ConstraintSettings& constraints);

  struct Workspace {
    voxel::VisibilityWorkspace visibility;
  };

  // All terms of a left-eye pose. Throws Error(not_finite) for a pose that is not finite.
  Evaluation evaluate(const Pose& X_WC, Workspace& workspace, Detail detail = Detail::search) const;
  // f_e of the terms: smaller is better. `greatest`: the largest value that is met (3.2.1.5).
  double score(const Evaluation& e, double greatest) const;
  // The factors of 3.15 for that greatest value.
  struct Lambdas {
    double interval = 0, distance = 0, landmarks = 0, forbidden = 0, motion = 0, reach = 0;
  };
  Lambdas lambdas(double greatest) const;
  // Every term by name, value and f_e among them; what a reply or a map shows.
  std::vector<std::pair<std::string, double>> terms(const Evaluation& e, double greatest) const;

  // What seeing a voxel is worth: 1 for each unknown voxel unless the settings weigh them.
  float weight(std::uint32_t voxel) const { return weights_.empty() ? 1.0f : weights_[voxel]; }
  const std::vector<float>& weights() const { return weights_; }  // by voxel; empty: 1 each
  bool weighted() const { return !weights_.empty(); }

  // False where there are no stored features, or fewer than twice the least number that is asked for.
  bool landmark_term() const { return landmark_term_; }
  // What views are judged by: without the unknown voxels that do not count.
  const voxel::VisibilityScene& visibility() const { return likely_ ? *likely_ : whole_; }
  // Everything that is unknown; N_u as it is reported. The same as visibility() if all counts.
  const voxel::VisibilityScene& whole() const { return whole_; }
  bool everything_counts() const { return !likely_; }
  // The situation with the grid of visibility(): what hides what when views are judged.
  const Situation& judged() const { return likely_ ? likely_situation_ : situation_; }
  const Constraints& constraints() const { return constraints_; }
  const Situation& situation() const { return situation_; }
  // As given, but with the threshold `pair.more_than_pixels` that quantification and voxel size lead to.
  const EvaluationSettings& settings() const { return settings_; }

  // 3.9 and 3.10 for one landmark of which `pixels` are visible, against `least_pixels`, seen along `view` (unit).
  double landmark_visibility(double pixels, double least_pixels, const Eigen::Vector3d& view,
                             const Eigen::Vector3d& normal) const;
  // The terms that need no rendering and no distance: forbidden poses (3.14), motion and reachability.
  void pose_terms(const Pose& X_WC, Evaluation& e) const;
  // 3.11 to 3.13 for the sum of the landmarks' visibilities.
  double landmark_penalty(double visible) const;
  // Landmark of a watched voxel: unit normal or zero, and the pixels that make it visible (pmin of 3.9).
  struct Mark {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double least_pixels = 0;
  };
  const Mark* mark(std::uint32_t voxel) const;

 private:
  static voxel::VisibilityScene make_visibility(const Situation& s, const voxel::OccupancyGrid& grid,
                                                const std::vector<SurfaceVoxel>& surface);
  double better_looks(const Pose& X_WC, voxel::VisibilityWorkspace& w) const;
  double value_of(const voxel::VoxelList& both, const voxel::PairGain& gain) const;
  double landmark_facing(const Eigen::Vector3d& view, const Eigen::Vector3d& normal) const;

  const Situation& situation_;
  EvaluationSettings settings_;
  std::vector<SurfaceVoxel> surface_;       // known surface; empty: quality does not count
  voxel::VisibilityScene whole_;
  std::optional<voxel::VisibilityScene> likely_;
  Situation likely_situation_;  // of likely_
  Constraints constraints_;
  bool landmark_term_ = false;
  std::vector<std::int32_t> mark_of_voxel_;  // -1: none; empty without landmarks
  std::vector<Mark> marks_;
  std::vector<float> quality_;               // of surface_
  std::vector<std::int32_t> surface_of_voxel_;
  std::vector<float> weights_;               // by voxel; empty: 1 each
};

}  // namespace periplus::nbv
