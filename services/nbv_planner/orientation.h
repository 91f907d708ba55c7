// Where to look from a given place: one wide rendering lists the unknown voxels that are visible from it; every yaw and
// pitch is then judged on that list, without rendering again.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "services/nbv_planner/evaluation.h"

namespace periplus::nbv {

// Points relative to the middle between the eyes, world axes [m].
using Directions = std::vector<Eigen::Vector3f>;

// What both eyes' images contain within the depth range.
struct PairWindow {
  double tan_horizontal = 0, tan_vertical = 0;  // half angles of one eye
  double baseline = 0;                          // [m]
  double depth_min = 0.6, depth_max = 2.5;      // [m]

  static PairWindow of(const StereoRig& rig, const voxel::PairOptions& options);
  // Points within the window of a pair that looks along yaw and pitch (positive down), roll 0.
  int count(const Directions& points, double yaw, double pitch) const;
};

struct Orientation {
  double yaw = 0, pitch = 0;  // [rad]
  int count = 0;              // points in the window
};

// The best orientation found: towards some of the points, then a compass search from the best few. No points: straight
// towards `fallback`. Pitch stays within [pitch_min, pitch_max].
Orientation choose_orientation(const PairWindow& window, const Directions& points, const Eigen::Vector3d& fallback,
                               double pitch_min, double pitch_max);

// A place between the eyes with its best orientation.
struct Sample {
  Pose X_WC = Pose::Identity();  // left eye
  int voxels = 0;                // estimate of N_u
  double landmarks = 0;          // estimate of the sum of ls ln
};
template <class Fields>
void visit_fields(Fields& fields, Sample& s) {
  fields(s.X_WC, s.voxels, s.landmarks);
}

// One wide rendering from p_W (left eye's position, roll 0).
Sample look_around(const Evaluator& evaluator, const Eigen::Vector3d& p_W, voxel::VisibilityWorkspace& workspace);

// Left eye of a pair whose middle is at p_W.
Pose left_eye(const Eigen::Vector3d& p_W, double yaw, double pitch, double baseline);

}  // namespace periplus::nbv
