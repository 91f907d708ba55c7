#include "services/nbv_planner/situation.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/core/error.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

ErrorCode refused(const std::function<void(Situation&)>& spoil) {
  Situation s = testing::patch_at_plus_x();
  spoil(s);
  try {
    check(s);
  } catch (const Error& e) {
    return e.code();
  }
  return ErrorCode::ok;
}

TEST(Situation, GoodOnesPassAndBadOnesSayWhy) {
  EXPECT_EQ(refused([](Situation&) {}), ErrorCode::ok);
  EXPECT_EQ(refused([](Situation& s) { s.grid = nullptr; }), ErrorCode::bad_input);
  EXPECT_EQ(refused([](Situation& s) { s.collision = nullptr; }), ErrorCode::bad_input);
  EXPECT_EQ(refused([](Situation& s) { std::swap(s.limits.height_min, s.limits.height_max); }), ErrorCode::bad_input);
  EXPECT_EQ(refused([](Situation& s) { s.limits.distance_max = s.limits.distance_min; }), ErrorCode::bad_input);
  EXPECT_EQ(refused([](Situation& s) { s.limits.pitch_max = 2; }), ErrorCode::bad_input);
  EXPECT_EQ(refused([](Situation& s) { s.limits.roll_max = -0.1; }), ErrorCode::bad_input);
  EXPECT_EQ(refused([](Situation& s) { s.limits.height_max = std::numeric_limits<double>::quiet_NaN(); }),
            ErrorCode::not_finite);
  EXPECT_EQ(refused([](Situation& s) { s.rig.baseline = -0.1; }), ErrorCode::bad_input);
  EXPECT_EQ(refused([](Situation& s) { s.rig.baseline = 0; }), ErrorCode::ok);  // one camera
  EXPECT_EQ(refused([](Situation& s) { s.limits.yaw_max = s.limits.yaw_min; }), ErrorCode::bad_input);
  EXPECT_EQ(refused([](Situation& s) { s.X_WC_now = Pose::Identity(); s.X_WC_now->translation().x() = NAN; }), ErrorCode::not_finite);
  EXPECT_EQ(refused([](Situation& s) { s.body.lower.z() = s.body.upper.z(); }), ErrorCode::bad_input);
  EXPECT_EQ(refused([](Situation& s) { s.body.lower = s.body.upper; }), ErrorCode::ok);  // a camera held by hand
  EXPECT_EQ(refused([](Situation& s) {
              s.forbidden.push_back(Pose::Identity());
              s.forbidden[0].translation().z() = std::numeric_limits<double>::infinity();
            }),
            ErrorCode::not_finite);
}

}  // namespace
}  // namespace periplus::nbv
