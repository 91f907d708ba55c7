#include "services/nbv_planner/tool/pose_text.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "common/core/error.h"

namespace periplus::nbv {
namespace {
constexpr double kRadPerDegree = std::numbers::pi / 180;
}

Pose parse_pose(std::string_view text, std::string_view what) {
  const auto expected = [&](const char* why) {
    throw_error(ErrorCode::bad_input, std::string(what) + " \"" + std::string(text.substr(0, 200)) + "\": " + why +
                                          "; x,y,z,yaw,pitch[,roll] in metres and degrees, or x,y,z,qw,qx,qy,qz are expected, without spaces");
  };
  std::vector<double> v;
  for (std::size_t at = 0; at <= text.size() && v.size() < 8;) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    double number = 0;
    const auto [end, error] = std::from_chars(text.data() + at, text.data() + comma, number);
    if (error != std::errc{} || end != text.data() + comma) expected("not a list of numbers");
    require(std::isfinite(number), ErrorCode::not_finite, std::string(what) + ": a pose must be made of finite numbers");
    v.push_back(number);
    at = comma + 1;
  }
  if (v.size() < 5 || v.size() > 7) expected("it has another count of numbers");
  const Eigen::Vector3d p(v[0], v[1], v[2]);
  if (v.size() == 7) {
    Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
    if (std::abs(q.norm() - 1) > 1e-3) expected("the quaternion's length is not 1");
    return make_pose(p, q.normalized().toRotationMatrix());
  }
  return look_along(p, v[3] * kRadPerDegree, v[4] * kRadPerDegree, v.size() > 5 ? v[5] * kRadPerDegree : 0);
}

std::string to_text(const Pose& X_WC) {
  // What is written as zero is no negative zero.
  const auto plain = [](const Eigen::Vector3d& v, double half_digit) -> Eigen::Vector3d { return (v.array().abs() < half_digit).select(0.0, v); };
  const Eigen::Vector3d p = plain(X_WC.translation(), 5e-7), ypr = plain(camera_yaw_pitch_roll(X_WC) / kRadPerDegree, 5e-5);
  char text[200];
  std::snprintf(text, sizeof text, "%.6f,%.6f,%.6f,%.4f,%.4f,%.4f", p.x(), p.y(), p.z(), ypr.x(), ypr.y(), ypr.z());
  return text;
}

}  // namespace periplus::nbv
