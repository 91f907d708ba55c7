// The evaluation function of a viewpoint (thesis 3.2.1): the unknown that it would show, and its constraints as smooth
// penalties.
//
//   f_e = lz Kz + lx Kroll + ly Kpitch + ld Kd + ll Kl + lf Kf - N_u                                        (3.15)
//
// lz, lx and ly follow the rule of 3.2.1.5: with the bound of an interval reached (K = 1) the penalty equals the largest
// value that N_u takes, `gain_scale`. For the same reason lf is at most that: K_f reaches far, and late in a run it would
// otherwise drive every view away from the little that is left to see. Beyond the thesis stands one more term, Kfar: the distance is bounded above too.
// World frame, metres, radians; pixels of the rig's camera.
#pragma once

#include <cstdint>
#include <vector>

#include "common/voxel/visibility.h"
#include "services/nbv_planner/constraints.h"
#include "services/nbv_planner/situation.h"

namespace periplus::nbv {

struct EvaluationSettings {
  int interval_exponent = 6;        // p of 3.7, even
  double distance_slope = 20;       // gamma of 3.8 [1/m]; r is 1
  int least_landmarks = 5;          // Nl_min of 3.11
  double landmark_reward = 1;       // eta of 3.12
  double landmark_slope = 20;       // beta of 3.10
  double landmark_cosine = 0.5;     // phi of 3.10: seen at up to 60 degrees from its normal
  double forbidden_slope = 1;       // delta of 3.14
  double lambda_distance = 100, lambda_landmarks = 1, lambda_forbidden = 1000;
  bool landmarks = true;            // false: never the landmark term
  voxel::PairOptions pair;          // threshold of N_u and the pair's depth range
};

struct Evaluation {
  voxel::PairGain gain;             // N_u and its pixels
  double k_height = 0, k_roll = 0, k_pitch = 0, k_distance = 0, k_far = 0, k_landmarks = 0, k_forbidden = 0;
  double visible_landmarks = 0;     // sum of ls ln
  Violation violation = Violation::none;
};
// For task_numbers.h: every field. A new one changes the size and belongs here as well.
template <class Fields>
void visit_fields(Fields& fields, Evaluation& e) {
  static_assert(sizeof(Evaluation) == 88);
  fields(e.gain.voxels, e.gain.pixels, e.k_height, e.k_roll, e.k_pitch, e.k_distance, e.k_far, e.k_landmarks,
         e.k_forbidden, e.visible_landmarks, e.violation);
}

// Immutable but for the workspaces: may be shared between threads.
class Evaluator {
 public:
  Evaluator(const Situation& situation, const EvaluationSettings& settings, const ConstraintSettings& constraints);

  struct Workspace {
    voxel::VisibilityWorkspace visibility;
  };

  // All terms of a left-eye pose. Where head, body or a forbidden pose rule it out, nothing is rendered and N_u is 0.
  // Throws Error(not_finite) for a pose that is not finite.
  Evaluation evaluate(const Pose& X_WC, Workspace& workspace) const;
  // f_e of the terms: smaller is better.
  double score(const Evaluation& e, double gain_scale) const;

  // False where there are no stored features, or fewer than twice the least number that is asked for.
  bool landmark_term() const { return landmark_term_; }
  const voxel::VisibilityScene& visibility() const { return visibility_; }
  const Constraints& constraints() const { return constraints_; }
  const Situation& situation() const { return situation_; }
  const EvaluationSettings& settings() const { return settings_; }

  // 3.9 and 3.10 for one landmark of which `pixels` are visible, against `least_pixels`, seen along `view` (unit).
  double landmark_visibility(double pixels, double least_pixels, const Eigen::Vector3d& view,
                             const Eigen::Vector3d& normal) const;
  // 3.11 to 3.13 for the sum of the landmarks' visibilities.
  double landmark_penalty(double visible) const;
  // Landmark of a watched voxel: unit normal or zero, and the pixels that make it visible (pmin of 3.9).
  struct Mark {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double least_pixels = 0;
  };
  const Mark* mark(std::uint32_t voxel) const;

 private:
  static voxel::VisibilityScene make_visibility(const Situation& s);

  const Situation& situation_;
  EvaluationSettings settings_;
  voxel::VisibilityScene visibility_;
  Constraints constraints_;
  bool landmark_term_ = false;
  std::vector<std::int32_t> mark_of_voxel_;  // -1: none
  std::vector<Mark> marks_;
};

}  // namespace periplus::nbv
