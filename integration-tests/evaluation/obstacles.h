// The solids and walls of a scene as the evaluation sees them: its own geometry, so that a fault of the libraries that the
// robot plans with shows instead of judging itself. World frame [m].
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry/pose.h"
#include "common/scene/scene.h"

namespace periplus::evaluation {

class Obstacles {
 public:
  explicit Obstacles(const scene::Scene& scene) : room_(scene.room.size), solids_(scene.solids) {}

  // True if the segment from p to q meets a solid. Walls stand around everything and hide nothing.
  bool block(const Eigen::Vector3d& p, const Eigen::Vector3d& q) const;
  // True if the box (full side lengths, centre at X_WB) comes within a tenth of a millimetre of a solid, or through a wall.
  bool touch_box(const Pose& X_WB, const Eigen::Vector3d& size) const;
  // True if the ball comes so near to a solid, or through a wall. The floor is none.
  bool touch_ball(const Eigen::Vector3d& center, double radius) const;

 private:
  Eigen::Vector3d room_;
  std::vector<scene::Solid> solids_;
};

}  // namespace periplus::evaluation
