#include "services/simulator/ideal_robot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/core/error.h"

namespace periplus::simulator {
namespace {

class IdealRobotTest : public testing::Test {
 protected:
  static std::shared_ptr<const robot::RobotModel> model() {
    static const auto loaded =
        robot::RobotModel::load_files(PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like.urdf", PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like.yaml");
    return loaded;
  }
  static ErrorCode code_of(IdealRobot& robot, std::uint64_t tick, const Eigen::VectorXd& positions) {
    try {
      robot.command(tick, Support::left, positions);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  }
  // Bends the right leg a little further each tick.
  static Eigen::VectorXd bent(const IdealRobot& robot, const char* joint, double by) {
    Eigen::VectorXd p = robot.state().positions;
    p[robot.model().joint_index(joint)] += by;
    return p;
  }
};

TEST_F(IdealRobotTest, StartsHalfSittingWhereToldWithFlatFeet) {
  IdealRobot robot(model(), {1, -0.5, 0.7});
  const RobotState& s = robot.state();
  EXPECT_EQ(s.tick, 0u);
  EXPECT_NEAR(s.X_W_left.translation().z(), 0, 1e-9);
  EXPECT_NEAR(s.X_W_right.translation().z(), 0, 1e-9);
  EXPECT_NEAR(to_pose2(s.X_W_left).yaw, 0.7, 1e-9);
  const Eigen::Vector3d between = (s.X_W_left.translation() + s.X_W_right.translation()) / 2;
  EXPECT_NEAR((between.head<2>() - Eigen::Vector2d(1, -0.5)).norm(), 0, 0.1);
}

TEST_F(IdealRobotTest, StandingFootStaysAndBaseFollows) {
  IdealRobot robot(model(), {0, 0, 0.3});
  const Pose left = robot.state().X_W_left, base = robot.state().X_WB;
  for (std::uint64_t tick = 0; tick < 100; ++tick) robot.command(tick, Support::left, bent(robot, "LLEG_JOINT4", 0.002));
  EXPECT_EQ(robot.state().tick, 100u);
  EXPECT_EQ(robot.state().stamp_ns, 500'000'000);
  EXPECT_EQ(robot.state().X_W_left.matrix(), left.matrix());
  EXPECT_GT((robot.state().X_WB.translation() - base.translation()).norm(), 0.05);
  EXPECT_GT((robot.state().X_W_right.translation() - left.translation()).norm(), 0.1);
  // The reported base pose and the joints give the anchored foot back.
  robot::Kinematics k(model());
  Eigen::VectorXd q(model()->dof());
  q.head<3>() = robot.state().X_WB.translation();
  q.segment<3>(3) = yaw_pitch_roll(robot.state().X_WB.linear());
  q.tail(robot.state().positions.size()) = robot.state().positions;
  k.set(q);
  EXPECT_NEAR((k.X_WS_left().matrix() - left.matrix()).norm(), 0, 1e-9);
  EXPECT_NEAR(robot.state().velocities[robot.model().joint_index("LLEG_JOINT4")], 0.4, 1e-9);
}

TEST_F(IdealRobotTest, AnchorMovesToTheOtherFootWhereItStandsThen) {
  IdealRobot robot(model(), {});
  robot.command(0, Support::left, bent(robot, "RLEG_JOINT0", 0.1));
  const Pose right = robot.state().X_W_right, left = robot.state().X_W_left;
  robot.command(1, Support::right, bent(robot, "LLEG_JOINT0", 0.1));
  EXPECT_EQ(robot.state().X_W_right.matrix(), right.matrix());
  EXPECT_GT(angle_between(robot.state().X_W_left, left), 0.05);
  const Pose moved = robot.state().X_W_left;
  robot.command(2, Support::both, bent(robot, "RLEG_JOINT0", 0.1));
  EXPECT_EQ(robot.state().X_W_left.matrix(), moved.matrix());
}

TEST_F(IdealRobotTest, RepeatedCommandIsAnsweredWithItsOwnState) {
  IdealRobot robot(model(), {}, {.states_kept = 4});
  for (std::uint64_t tick = 0; tick < 3; ++tick) robot.command(tick, Support::left, bent(robot, "CHEST_JOINT0", 0.01));
  const double now = robot.state().positions[robot.model().joint_index("CHEST_JOINT0")];
  const RobotState& again = robot.command(1, Support::left, bent(robot, "CHEST_JOINT0", 0.3));
  EXPECT_EQ(again.tick, 2u);
  EXPECT_NEAR(again.positions[robot.model().joint_index("CHEST_JOINT0")], 0.02, 1e-12);
  EXPECT_EQ(robot.state().tick, 3u);
  EXPECT_EQ(robot.state().positions[robot.model().joint_index("CHEST_JOINT0")], now);
  for (std::uint64_t tick = 3; tick < 8; ++tick) robot.command(tick, Support::left, bent(robot, "CHEST_JOINT0", 0.01));
  EXPECT_EQ(code_of(robot, 1, robot.state().positions), ErrorCode::bad_input);
}

TEST_F(IdealRobotTest, BadCommandsChangeNothing) {
  IdealRobot robot(model(), {});
  const Eigen::VectorXd good = robot.state().positions;
  EXPECT_EQ(code_of(robot, 5, good), ErrorCode::bad_input);
  EXPECT_EQ(code_of(robot, 0, good.head(3)), ErrorCode::bad_size);
  Eigen::VectorXd bad = good;
  bad[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code_of(robot, 0, bad), ErrorCode::not_finite);
  EXPECT_EQ(code_of(robot, 0, bent(robot, "LLEG_JOINT3", 3)), ErrorCode::motion_joint_limit);
  EXPECT_EQ(robot.state().tick, 0u);
  EXPECT_EQ(robot.state().positions, good);
  EXPECT_EQ(code_of(robot, 0, good), ErrorCode::ok);
}

TEST_F(IdealRobotTest, FallsWhenTold) {
  IdealRobot robot(model(), {}, {.fall_at_tick = 2});
  const Eigen::VectorXd still = robot.state().positions;
  EXPECT_FALSE(robot.command(0, Support::both, still).fallen);
  EXPECT_TRUE(robot.command(1, Support::both, still).fallen);
  EXPECT_TRUE(robot.command(2, Support::both, still).fallen);
}

TEST_F(IdealRobotTest, EyesLookForwardAndDownAtTheBaseline) {
  IdealRobot robot(model(), {});
  const Pose left = robot.X_WC("left"), right = robot.X_WC("right");
  EXPECT_NEAR((left.inverse() * right.translation() - Eigen::Vector3d(0.144, 0, 0)).norm(), 0, 1e-9);
  EXPECT_GT(left.linear().col(2).x(), 0.9);
  EXPECT_LT(left.linear().col(2).z(), 0);
  EXPECT_GT(left.translation().z(), 1.0);
}

}  // namespace
}  // namespace periplus::simulator
