#include "common/robot/capsule_distance.h"

#include <algorithm>

namespace periplus::robot {

ClosestPoints closest_points(const Eigen::Vector3d& a1, const Eigen::Vector3d& b1, const Eigen::Vector3d& a2, const Eigen::Vector3d& b2) {
  constexpr double kPoint = 1e-14;     // squared length below which a segment is a point [m2]
  constexpr double kParallel = 1e-12;  // [m4]
  const Eigen::Vector3d d1 = b1 - a1, d2 = b2 - a2, r = a1 - a2;
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r);
  const auto clamp = [](double x) { return std::clamp(x, 0.0, 1.0); };
  double s = 0, t = 0;
  if (a > kPoint && e > kPoint) {
    const double b = d1.dot(d2), c = d1.dot(r), denominator = a * e - b * b;
    s = denominator > kParallel ? clamp((b * f - c * e) / denominator) : 0.5;
    t = (b * s + f) / e;
    if (t < 0) {
      t = 0;
      s = clamp(-c / a);
    } else if (t > 1) {
      t = 1;
      s = clamp((b - c) / a);
    }
  } else if (a > kPoint) {
    s = clamp(-d1.dot(r) / a);
  } else if (e > kPoint) {
    t = clamp(f / e);
  }
  ClosestPoints result{a1 + s * d1, a2 + t * d2, 0};
  result.distance = (result.on_first - result.on_second).norm();
  return result;
}

}  // namespace periplus::robot
