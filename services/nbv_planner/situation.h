// What a next best view is planned on: domain types only. World frame W, metres, radians; camera poses are those of the
// left eye's optical frame.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/object_model/perception.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::nbv {

// How likely the robot's body can bring the left eye to a pose, by whoever knows.
class Reachability {
 public:
  virtual ~Reachability() = default;
  // 0 (never) to 1 (surely). Called from several threads at once.
  virtual double of(const Pose& X_WC) const = 0;
};

struct Situation {
  std::shared_ptr<const voxel::OccupancyGrid> grid;
  std::vector<object_model::Landmark> landmarks;  // stored features; may be empty
  scene::Scene scene;
  std::shared_ptr<const scene::CollisionWorld> collision;
  robot::ViewLimits limits;   // constraints 3.1-3.4 and the distances to the nearest occupied voxel
  robot::BodyBox body;        // what the robot needs on the floor; a point: nothing
  StereoRig rig;              // baseline 0: one camera
  std::vector<Pose> forbidden;  // constraint 3.6: left-eye poses that turned out unreachable
  std::optional<Pose> X_WC_now;  // where the left eye is: the motion's cost counts from there
  std::vector<Pose> views;       // left-eye poses of the looks so far; for the quality of known surface
  std::shared_ptr<const Reachability> reachability;  // null: every pose is as good as another
};

// Throws Error(bad_input | not_finite) with what to change: limits that are no intervals, a rig or a pose that cannot be.
void check(const Situation& situation);

}  // namespace periplus::nbv
