#include "services/vision_server/camera_pose.h"

#include <map>
#include <string>

#include "common/core/error.h"

namespace periplus::vision {

Eigen::VectorXd configuration(const robot::RobotModel& model, const JointPositions& joints, const Pose& X_WB) {
  const std::map<std::string, double> by_name(joints.begin(), joints.end());
  Eigen::VectorXd q(model.dof());
  q.head<3>() = X_WB.translation();
  q.segment<3>(3) = yaw_pitch_roll(X_WB.linear());
  Eigen::Index i = 6;
  for (const robot::Joint& joint : model.joints()) {
    const auto it = by_name.find(joint.name);
    require(it != by_name.end(), ErrorCode::vision_images_missing,
            "the joint states carry no joint '" + joint.name + "', so the camera's pose is unknown; check that robot "
            "model and robot agree");
    q[i++] = it->second;
  }
  return q;
}

Pose left_eye_pose(const std::shared_ptr<const robot::RobotModel>& model, const JointPositions& joints,
                   const Pose& X_WB) {
  robot::Kinematics kinematics(model);
  kinematics.set(configuration(*model, joints, X_WB));
  return kinematics.X_WC("left");
}

}  // namespace periplus::vision
