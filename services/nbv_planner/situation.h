// What a next best view is planned on: domain types only. World frame W, metres, radians; camera poses are those of the
// left eye's optical frame.
#pragma once

#include <memory>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/object_model/perception.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::nbv {

struct Situation {
  std::shared_ptr<const voxel::OccupancyGrid> grid;
  std::vector<object_model::Landmark> landmarks;  // stored features; may be empty
  scene::Scene scene;
  std::shared_ptr<const scene::CollisionWorld> collision;
  robot::ViewLimits limits;   // constraints 3.1-3.4 and the distances to the nearest occupied voxel
  robot::BodyBox body;        // what the robot needs on the floor
  StereoRig rig;
  std::vector<Pose> forbidden;  // constraint 3.6: left-eye poses that turned out unreachable
};

// Throws Error(bad_input | not_finite) with what to change: limits that are no intervals, a rig or a pose that cannot be.
void check(const Situation& situation);

}  // namespace periplus::nbv
