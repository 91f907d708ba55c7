// Where the half-sitting robot may stand: its bounding box on the floor against the known environment and the occupied
// voxels of the object (thesis 5.2.3). World frame W, floor at z = 0; a body pose is the floor frame below the base.
//
// The object's box may grow over the place where the robot stands (thesis 5.1.1), with voxels that nobody has looked at. No object is
// where the robot is: unknown voxels there are free. What depth has shown to be the object's is never left out.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/geometry/pose.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::walk {

enum class Blocked { no, by_scene, by_object };

// Immutable after construction.
class FloorSpace {
 public:
  // `object` may be null. Voxels that are unknown or known block; those of the environment are the scene's business.
  // lower, upper: rectangle of the floor in which to look for paths [m]. Throws Error(bad_input) if it is empty.
  FloorSpace(std::shared_ptr<const scene::CollisionWorld> world, const robot::BodyBox& body,
             const voxel::OccupancyGrid* object, const Eigen::Vector2d& lower, const Eigen::Vector2d& upper);

  // What the box touches when it stands at `body`; each of its four sides is first moved inwards by `shrink` [m].
  Blocked blocked(const Pose2& body, double shrink = 0) const;

  // The floor as it is for a robot that stands at `body`: columns in which no voxel is known do not block if its box, moved inwards by
  // `shrink` [m], touches them there. All others block as before.
  FloorSpace left_from(const Pose2& body, double shrink) const;

  const Eigen::Vector2d& lower() const { return lower_; }
  const Eigen::Vector2d& upper() const { return upper_; }

 private:
  struct Column {
    Eigen::Vector2d center{0, 0};  // on the floor
    bool known = false;            // one of its voxels is
  };
  // The robot's box, moved inwards; and whether it touches a column.
  struct Standing;
  Standing standing(const Pose2& body, double shrink) const;
  bool touches(const Standing& standing, const Column& column) const;

  std::shared_ptr<const scene::CollisionWorld> world_;
  robot::BodyBox body_;
  Eigen::Vector2d lower_, upper_;
  std::vector<Column> columns_;           // that are occupied
  double column_radius_ = 0;              // of the circle around a column's footprint [m]
  Eigen::Vector2d object_center_{0, 0};
  double object_radius_ = -1;  // of the circle around all columns; negative: none
};

}  // namespace periplus::walk
