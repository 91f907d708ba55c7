// Hard constraints on where the cameras may be: what a found view must satisfy whatever its gain.
//
// - height, pitch, roll and yaw of the left eye within the limits (3.1, 3.3, 3.4; yaw alike);
// - nearest occupied voxel's centre within the distance limits (3.2, and the far end of the pair's range);
// - a sphere about each eye, and what lies between them, free of the scene and inside the room;
// - the half-sitting robot's box, standing where the head is, free of the scene and of occupied voxels, and out of the
//   object's whole box where that stands on the floor;
// - not within `forbidden_distance` and `forbidden_angle` of a forbidden pose (3.6).
//
// World frame, metres, radians. Immutable: may be shared between threads.
#pragma once

#include <vector>

#include "common/voxel/visibility.h"
#include "services/nbv_planner/situation.h"

namespace periplus::nbv {

struct ConstraintSettings {
  double head_radius = 0.15;       // [m]
  double base_behind_eyes = 0.10;  // the base stands that far behind the eyes, along their yaw [m]
  double body_shrink = 0.05;       // taken off the body box at each side: head and base do not turn as one [m]
  double forbidden_distance = 0.10;       // [m]
  double forbidden_angle = 10 * 0.017453292519943295;  // [rad]
};

enum class Violation { none, not_finite, height, pitch, roll, yaw, room, too_near, too_far, head, body, forbidden };
const char* to_string(Violation violation);

// How far a yaw lies from the middle of its limits, in halves of their width: 1 at a bound, 0 where every yaw is free.
double yaw_share(const robot::ViewLimits& limits, double yaw);

class Constraints {
 public:
  // `visibility` is built from the situation's grid; both must outlive this.
  Constraints(const Situation& situation, const voxel::VisibilityScene& visibility, const ConstraintSettings& settings);

  const ConstraintSettings& settings() const { return settings_; }

  // Distance to the nearest occupied voxel's centre; infinity if there is none.
  double nearest_voxel(const Eigen::Vector3d& p_W) const;

  // The first constraint that a left-eye pose violates. `distance`, where given: nearest_voxel of it.
  Violation check(const Pose& X_WC, double* distance = nullptr) const;
  // The same for what is known of the position alone: `p_W` between the eyes, the head anyhow, the body facing `yaw`.
  Violation check_position(const Eigen::Vector3d& p_W, double yaw) const;
  // True if the pose is within both thresholds of a forbidden one.
  bool forbidden(const Pose& X_WC) const;

 private:
  bool in_room(const Eigen::Vector3d& p_W) const;
  bool body_free(const Eigen::Vector3d& p_W, double yaw) const;
  bool body_meets_voxels(const Pose& X_WB, const Eigen::Vector3d& half) const;
  bool body_meets_grid_box(const Pose& X_WB, const Eigen::Vector3d& half) const;

  struct Box {  // around voxels' centres, grid frame
    Eigen::Vector3d lower, upper;

    double squared_distance(const Eigen::Vector3d& p_G) const;
    void include(const Box& other);
  };
  struct Cluster : Box {  // surface voxels of one brick
    std::vector<Eigen::Vector3d> centers_G;
  };
  struct Region : Box {  // clusters [first, end) of neighbouring bricks
    std::size_t first = 0, end = 0;
  };
  // Calls for clusters whose box may be met; `far` says of a box that it is not.
  template <class Far, class Call>
  bool any_cluster(const Far& far, const Call& call) const;
  const Situation& situation_;
  ConstraintSettings settings_;
  Pose X_GW_;
  std::vector<Cluster> clusters_;
  std::vector<Region> regions_;
  bool on_floor_ = false;
};

}  // namespace periplus::nbv
