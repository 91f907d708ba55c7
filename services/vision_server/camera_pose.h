// Where the left eye was: from measured joints and the base pose that the robot reports.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "common/geometry/pose.h"
#include "common/robot/robot_model.h"
#include "services/vision_server/captured_view.h"

namespace periplus::vision {

// The robot's configuration (robot_model.h). Throws Error(vision_images_missing) if a joint of the model is not among
// `joints`; joints that the model does not know are ignored.
Eigen::VectorXd configuration(const robot::RobotModel& model, const JointPositions& joints, const Pose& X_WB);

// Pose of the left eye's optical frame in the world.
Pose left_eye_pose(const std::shared_ptr<const robot::RobotModel>& model, const JointPositions& joints, const Pose& X_WB);

}  // namespace periplus::vision
