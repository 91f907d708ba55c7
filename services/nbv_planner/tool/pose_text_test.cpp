#include "services/nbv_planner/tool/pose_text.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::nbv {
namespace {

TEST(PoseText, ReadsBack) {
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const Pose X = look_along({random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(0, 2)}, random.uniform(-3.1, 3.1),
                              random.uniform(-1.5, 1.5), random.uniform(-3, 3));
    const Pose Y = parse_pose(to_text(X), "--forbid");
    EXPECT_LT((X.translation() - Y.translation()).norm(), 1e-6);
    EXPECT_LT(angle_between(X, Y), 1e-5);
    const Eigen::Quaterniond q(X.linear());
    char text[200];
    std::snprintf(text, sizeof text, "%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f", X.translation().x(), X.translation().y(), X.translation().z(), q.w(), q.x(), q.y(), q.z());
    EXPECT_LT(angle_between(X, parse_pose(text, "--forbid")), 1e-6);
  }
  EXPECT_TRUE(parse_pose("1,-2,1.2,90,10", "").isApprox(look_along({1, -2, 1.2}, std::numbers::pi / 2, std::numbers::pi / 18), 1e-12));
}

TEST(PoseText, RefusesWhatIsNoPose) {
  for (const char* text : {"", "1,2,3", "1,2,3,4,5,6,7,8", "1,2,3,4,x", "1,2,3,,5", "1,2,3,4,5,", "1, 2,3,4,5", "0,0,1,2,0,0,0"}) {
    try {
      parse_pose(text, "--forbid");
      ADD_FAILURE() << text;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(e.what()).find("--forbid"), std::string::npos);
    }
  }
  try {
    parse_pose("nan,0,1,2,0", "--forbid");
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::not_finite);
  }
}

}  // namespace
}  // namespace periplus::nbv
