// Rigid poses. X_AB is the pose of frame B in frame A: p_A = X_AB * p_B. World frame W: z up, floor at z = 0. Camera
// frames C are optical: x right, y down, z forward. Body frames: x forward, y left, z up.
#pragma once

#include <Eigen/Geometry>

namespace periplus {

using Pose = Eigen::Isometry3d;

// Pose on the floor.
struct Pose2 {
  double x = 0, y = 0;  // [m]
  double yaw = 0;       // [rad]
};

// R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Matrix3d rotation_from_yaw_pitch_roll(double yaw, double pitch, double roll);
// Inverse of the above: (yaw, pitch, roll), pitch in [-pi/2, pi/2].
Eigen::Vector3d yaw_pitch_roll(const Eigen::Matrix3d& R);

Pose make_pose(const Eigen::Vector3d& p, const Eigen::Matrix3d& R);
Pose to_pose(const Pose2& floor_pose, double z = 0);
// Position and heading of the x axis.
Pose2 to_pose2(const Pose& X_WB);
// Pose2 algebra: a * b is b given in a, seen from a's parent.
Pose2 compose(const Pose2& a, const Pose2& b);
Pose2 inverse(const Pose2& a);
// Into (-pi, pi].
double wrap_angle(double angle);
// Half way from one heading to the other, the shorter way round [rad]; within pi / 2 of `a`, not wrapped.
double mean_yaw(double a, double b);
// Half way between two poses, as the middle of two feet: mean position, mean heading in (-pi, pi].
Pose2 middle(const Pose2& a, const Pose2& b);

// Optical camera pose at p_WC looking along yaw and pitch (positive down) with the image upright but for `roll`.
Pose look_along(const Eigen::Vector3d& p_WC, double yaw, double pitch, double roll = 0);
// Optical camera pose at p_WC with its axis through p_WT, image upright.
Pose look_at(const Eigen::Vector3d& p_WC, const Eigen::Vector3d& p_WT);
// (yaw, pitch, roll) such that look_along(X_WC.translation(), ...) is X_WC.
Eigen::Vector3d camera_yaw_pitch_roll(const Pose& X_WC);
// Angle of the rotation from A to B [rad].
double angle_between(const Pose& X_WA, const Pose& X_WB);

bool is_finite(const Pose& X);

}  // namespace periplus
