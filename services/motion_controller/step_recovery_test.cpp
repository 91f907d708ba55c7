#include "services/motion_controller/step_recovery.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "services/motion_controller/walk_motion.h"

namespace periplus::motion {
namespace {

class StepRecoveryTest : public ::testing::Test {
 protected:
  StepRecoveryTest() {
    const BodyTarget standing = ik.measure(start);
    Pose2 body = to_pose2(standing.X_left);
    body = compose(body, {0, -0.095, 0});
    for (int i = 0; i < 6; ++i) {
      if (i < 5) body = compose(body, {0.17, 0, 0.06});
      steps.push_back({i % 2, compose(body, {0, i % 2 == 0 ? 0.095 : -0.095, 0})});
    }
  }
  const std::string folder = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/";
  std::shared_ptr<const robot::RobotModel> model =
      robot::RobotModel::load_files(folder + "hrp2like.urdf", folder + "hrp2like.yaml");
  WholeBodyIk ik{model};
  Eigen::VectorXd start = model->half_sitting({-1, 0.5, -2});
  std::vector<Step> steps;
};

TEST_F(StepRecoveryTest, FromAnyTickTheWalkIsTakenUpAndEndsWhereItShould) {
  const WalkMotion whole(model, start, steps);
  int lifted = 0;
  for (std::size_t k = 100; k < whole.commands().size(); k += 83) {
    Eigen::VectorXd q = whole.commands()[k].q;
    BodyTarget now = ik.measure(q);
    const WalkPlace place = find_place(steps, now.X_left, now.X_right);
    if (place.lifted) {
      ++lifted;
      ASSERT_GE(place.done, 1u);
      EXPECT_EQ(whole.commands()[k].support, 1 - *place.lifted);
      const Pose standing = *place.lifted == 0 ? now.X_right : now.X_left;
      const LandFoot landing(model, q, *place.lifted, steps[place.done - 1].sole);
      for (const Command& c : landing.commands()) {
        EXPECT_EQ(c.support, 1 - *place.lifted);
        const BodyTarget at = ik.measure(c.q);
        const Pose& X = *place.lifted == 0 ? at.X_right : at.X_left;
        EXPECT_LT((X.translation() - standing.translation()).norm(), 1e-6);
      }
      std::string joint;
      EXPECT_LE(greatest_speed_ratio(*model, q, landing.commands(), 0, 0.005, joint), 1.0) << joint;
      q = landing.commands().back().q;
      now = ik.measure(q);
      const Pose2 landed = to_pose2(*place.lifted == 0 ? now.X_left : now.X_right);
      EXPECT_NEAR(landed.x, steps[place.done - 1].sole.x, 1e-6);
      EXPECT_NEAR((*place.lifted == 0 ? now.X_left : now.X_right).translation().z(), 0, 1e-6);
    }
    const std::vector<Step> rest(steps.begin() + static_cast<std::ptrdiff_t>(place.done), steps.end());
    const WalkMotion motion(model, q, rest);
    if (!motion.commands().empty()) q = motion.commands().back().q;
    now = ik.measure(q);
    EXPECT_NEAR(to_pose2(now.X_left).x, steps[4].sole.x, 1e-5) << "command " << k;
    EXPECT_NEAR(to_pose2(now.X_right).y, steps[5].sole.y, 1e-5) << "command " << k;
  }
  EXPECT_GT(lifted, 5);
}

TEST_F(StepRecoveryTest, ANewWalkBeginsAtItsFirstStep) {
  const BodyTarget now = ik.measure(start);
  EXPECT_EQ(find_place(steps, now.X_left, now.X_right).done, 0u);
  EXPECT_EQ(find_place({}, now.X_left, now.X_right).done, 0u);
}

TEST_F(StepRecoveryTest, AnUnexplainedFootInTheAirIsAFault) {
  BodyTarget now = ik.measure(start);
  now.X_left.translation().z() = 0.03;
  const auto refused = [&](const std::vector<Step>& s) {
    try {
      find_place(s, now.X_left, now.X_right);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  };
  EXPECT_EQ(refused({}), ErrorCode::motion_robot_fault);
  now.X_right.translation().z() = 0.03;
  EXPECT_EQ(refused(steps), ErrorCode::motion_robot_fault);
}

}  // namespace
}  // namespace periplus::motion
