#include "services/nbv_planner/situation.h"

#include <cmath>
#include <numbers>

#include "common/core/error.h"

namespace periplus::nbv {

void check(const Situation& s) {
  require(s.grid != nullptr, ErrorCode::bad_input, "planning a view needs the object's grid");
  require(s.collision != nullptr, ErrorCode::bad_input, "planning a view needs the scene's collision world");
  s.grid->geometry().check();
  s.rig.camera.check();
  if (s.rig.baseline != 0) s.rig.check();  // without a baseline: one camera that measures depth by itself
  const robot::ViewLimits& l = s.limits;
  for (double v : {l.height_min, l.height_max, l.pitch_min, l.pitch_max, l.roll_max, l.yaw_min, l.yaw_max, l.distance_min,
                   l.distance_max}) {
    require(std::isfinite(v), ErrorCode::not_finite, "a view limit is not a finite number; give all limits as numbers");
  }
  require(0 <= l.height_min && l.height_min < l.height_max && l.height_max <= 10, ErrorCode::bad_input,
          "the height limits must satisfy 0 <= minimum < maximum <= 10 m");
  require(-std::numbers::pi / 2 <= l.pitch_min && l.pitch_min < l.pitch_max && l.pitch_max <= std::numbers::pi / 2,
          ErrorCode::bad_input, "the pitch limits must satisfy -pi/2 <= minimum < maximum <= pi/2");
  require(0 <= l.roll_max && l.roll_max <= std::numbers::pi, ErrorCode::bad_input, "the greatest roll must lie in 0..pi");
  require(-std::numbers::pi <= l.yaw_min && l.yaw_min < l.yaw_max && l.yaw_max <= l.yaw_min + 2 * std::numbers::pi + 1e-9,
          ErrorCode::bad_input,
          "the yaw limits must satisfy -pi <= minimum < maximum <= minimum + 2 pi; -pi..pi leaves every yaw free");
  require(0 <= l.distance_min && l.distance_min < l.distance_max && l.distance_max <= 100, ErrorCode::bad_input,
          "the distance limits must satisfy 0 <= minimum < maximum <= 100 m");
  require(s.body.lower == s.body.upper || (s.body.lower.array() < s.body.upper.array()).all(), ErrorCode::bad_input,
          "the robot's body box must have lower < upper along each axis, or be a point where there is no body");
  require(!s.X_WC_now || is_finite(*s.X_WC_now), ErrorCode::not_finite,
          "the pose where the camera is has a number that is not finite; leave it out");
  for (const Pose& X : s.views) {
    require(is_finite(X), ErrorCode::not_finite, "a view so far has a number that is not finite; leave that view out");
  }
  for (const Pose& X : s.forbidden) {
    require(is_finite(X), ErrorCode::not_finite, "a forbidden pose has a number that is not finite; leave that pose out");
  }
}

}  // namespace periplus::nbv
