#include "common/geometry/pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace periplus {

Eigen::Matrix3d rotation_from_yaw_pitch_roll(double yaw, double pitch, double roll) {
  const double cy = std::cos(yaw), sy = std::sin(yaw);
  const double cp = std::cos(pitch), sp = std::sin(pitch);
  const double cr = std::cos(roll), sr = std::sin(roll);
  Eigen::Matrix3d R;
  R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  return R;
}

Eigen::Vector3d yaw_pitch_roll(const Eigen::Matrix3d& R) {
  const double sp = std::clamp(-R(2, 0), -1.0, 1.0);
  const double pitch = std::asin(sp);
  if (std::abs(sp) > 1.0 - 1e-12) return {std::atan2(-R(0, 1), R(1, 1)), pitch, 0.0};
  return {std::atan2(R(1, 0), R(0, 0)), pitch, std::atan2(R(2, 1), R(2, 2))};
}

Pose make_pose(const Eigen::Vector3d& p, const Eigen::Matrix3d& R) {
  Pose X = Pose::Identity();
  X.linear() = R;
  X.translation() = p;
  return X;
}

Pose to_pose(const Pose2& f, double z) {
  return make_pose({f.x, f.y, z}, rotation_from_yaw_pitch_roll(f.yaw, 0, 0));
}

Pose2 to_pose2(const Pose& X) {
  return {X.translation().x(), X.translation().y(), std::atan2(X.linear()(1, 0), X.linear()(0, 0))};
}

Pose2 compose(const Pose2& a, const Pose2& b) {
  const double c = std::cos(a.yaw), s = std::sin(a.yaw);
  return {a.x + c * b.x - s * b.y, a.y + s * b.x + c * b.y, wrap_angle(a.yaw + b.yaw)};
}

Pose2 inverse(const Pose2& a) {
  const double c = std::cos(a.yaw), s = std::sin(a.yaw);
  return {-c * a.x - s * a.y, s * a.x - c * a.y, wrap_angle(-a.yaw)};
}

double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2 * std::numbers::pi);
  return wrapped == -std::numbers::pi ? std::numbers::pi : wrapped;
}

double mean_yaw(double a, double b) { return a + 0.5 * wrap_angle(b - a); }

Pose2 middle(const Pose2& a, const Pose2& b) {
  return {0.5 * (a.x + b.x), 0.5 * (a.y + b.y), wrap_angle(mean_yaw(a.yaw, b.yaw))};
}

namespace {
// Body axes (x forward, y left, z up) to optical axes (x right, y down, z forward).
const Eigen::Matrix3d& body_from_optical() {
  static const Eigen::Matrix3d R = (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
  return R;
}
}  // namespace

Pose look_along(const Eigen::Vector3d& p_WC, double yaw, double pitch, double roll) {
  return make_pose(p_WC, rotation_from_yaw_pitch_roll(yaw, pitch, roll) * body_from_optical());
}

Pose look_at(const Eigen::Vector3d& p_WC, const Eigen::Vector3d& p_WT) {
  const Eigen::Vector3d d = p_WT - p_WC;
  return look_along(p_WC, std::atan2(d.y(), d.x()), std::atan2(-d.z(), std::hypot(d.x(), d.y())));
}

Eigen::Vector3d camera_yaw_pitch_roll(const Pose& X_WC) {
  return yaw_pitch_roll(X_WC.linear() * body_from_optical().transpose());
}

double angle_between(const Pose& X_WA, const Pose& X_WB) {
  return Eigen::AngleAxisd(X_WA.linear().transpose() * X_WB.linear()).angle();
}

bool is_finite(const Pose& X) { return X.matrix().allFinite(); }

}  // namespace periplus
