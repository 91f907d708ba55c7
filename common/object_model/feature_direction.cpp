#include "common/object_model/feature_direction.h"

#include <Eigen/Geometry>
#include <cmath>

namespace periplus::object_model {

Eigen::Vector3d surface_direction(const Feature& feature, const Pinhole& camera, const Pose& X_WC) {
  if (feature.normal_W.isZero()) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d n = X_WC.linear().transpose() * feature.normal_W;
  const Eigen::Vector3d ray((feature.u - camera.cx) / camera.fx, (feature.v - camera.cy) / camera.fy, 1);
  const Eigen::Vector3d along(std::cos(feature.angle) / camera.fx, std::sin(feature.angle) / camera.fy, 0);
  // In the surface, and in the plane of the rays along the line through the feature.
  Eigen::Vector3d t = n.cross(ray.cross(along));
  const double length = t.norm();
  if (!(length > 0) || !std::isfinite(length)) return Eigen::Vector3d::Zero();
  t /= length;
  // Of its two senses the one whose picture moves along the angle.
  const Eigen::Vector2d moves = t.head<2>() - t.z() * ray.head<2>();
  if (moves.dot(along.head<2>()) < 0) t = -t;
  return X_WC.linear() * t;
}

}  // namespace periplus::object_model
