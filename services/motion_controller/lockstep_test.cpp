#include "services/motion_controller/lockstep.h"

#include <gtest/gtest.h>

#include "common/core/error.h"

namespace periplus::motion {
namespace {

// A line of commands for the first joint.
class Line : public Trajectory {
 public:
  Line(const Eigen::VectorXd& q, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) {
      commands_.push_back({2, q});
      commands_.back().q(6) += 0.001 * static_cast<double>(k + 1);
    }
  }
  double fraction(std::size_t executed) const override {
    return static_cast<double>(executed) / static_cast<double>(commands_.size());
  }
  std::string describe(std::size_t) const override { return "line"; }
  void halt(std::size_t executed) override { commands_.resize(std::min(commands_.size(), executed + 3)); }
};

// Goes where it is told, and may lose messages, fall, or lag.
class PretendRobot : public RobotLink {
 public:
  void send(std::uint64_t tick, int support, const Eigen::VectorXd& joints) override {
    ++sent;
    last_support = support;
    if (sent % lose_every == 0) return;
    if (tick == report.tick) {  // anything else was executed before
      report.joints = joints;
      report.joints(0) -= lag;
      ++report.tick;
      ++executed;
      report.fallen = report.tick == falls_at;
      if (report.tick == jumps_at) report.tick += 5;
    }
    if (sent % lose_answer_every != 0) answered = true;
  }
  std::optional<RobotReport> wait(std::uint64_t tick, double) override {
    if (silent || !answered || report.tick < tick) return std::nullopt;
    answered = false;
    return report;
  }
  RobotReport report;
  std::uint64_t sent = 0, executed = 0, lose_every = 1u << 30, lose_answer_every = 1u << 30, falls_at = 1u << 30,
                jumps_at = 1u << 30;
  double lag = 0;
  int last_support = -1;
  bool silent = false, answered = false;
};

class LockstepTest : public ::testing::Test {
 protected:
  LockstepTest() {
    robot.report.tick = 100;
    robot.report.joints = model->half_sitting().tail(model->dof() - 6);
    robot.report.X_base = make_pose({1, 2, 0.6}, rotation_from_yaw_pitch_roll(0.5, 0.1, -0.1));
  }
  ErrorCode failure(std::size_t count) {
    Line line(model->half_sitting(), count);
    try {
      execute(
          line, robot.report, robot, *model, {}, [] { return false; }, [](std::size_t) {});
    } catch (const Error& e) {
      message = e.what();
      return e.code();
    }
    return ErrorCode::ok;
  }
  const std::string folder = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/";
  std::shared_ptr<const robot::RobotModel> model =
      robot::RobotModel::load_files(folder + "hrp2like.urdf", folder + "hrp2like.yaml");
  PretendRobot robot;
  std::string message;
};

TEST_F(LockstepTest, ExecutesEveryCommandOnceWhateverIsLost) {
  robot.lose_every = 7;
  robot.lose_answer_every = 5;
  Line line(model->half_sitting(), 60);
  std::size_t reports = 0;
  const Execution done = execute(
      line, robot.report, robot, *model, {}, [] { return false; }, [&](std::size_t) { ++reports; });
  EXPECT_EQ(done.commands, 60u);
  EXPECT_EQ(robot.executed, 60u);
  EXPECT_GT(robot.sent, 70u);
  EXPECT_EQ(done.report.tick, 160u);
  EXPECT_NEAR(done.report.joints(0), model->half_sitting()(6) + 0.06, 1e-12);
  EXPECT_EQ(reports, 3u);
  EXPECT_FALSE(done.halted);
  EXPECT_EQ(robot.last_support, 2);
}

TEST_F(LockstepTest, HaltsAtTheEndOfTheCutTrajectory) {
  Line line(model->half_sitting(), 60);
  const Execution done = execute(
      line, robot.report, robot, *model, {}, [this] { return robot.executed >= 10; }, [](std::size_t) {});
  EXPECT_TRUE(done.halted);
  EXPECT_EQ(done.commands, 13u);
}

TEST_F(LockstepTest, TellsASilentRobot) {
  robot.silent = true;
  EXPECT_EQ(failure(5), ErrorCode::motion_robot_silent);
  EXPECT_EQ(robot.sent, 20u);  // every 0.25 s for 5 s
}

TEST_F(LockstepTest, TellsAFallenOne) {
  robot.falls_at = 103;
  EXPECT_EQ(failure(5), ErrorCode::motion_robot_fault);
}

TEST_F(LockstepTest, TellsAnotherController) {
  robot.jumps_at = 103;
  EXPECT_EQ(failure(5), ErrorCode::motion_robot_fault);
  EXPECT_NE(message.find("another"), std::string::npos);
}

TEST_F(LockstepTest, NamesAJointThatDoesNotFollow) {
  robot.lag = 0.5;
  EXPECT_EQ(failure(5), ErrorCode::motion_robot_fault);
  EXPECT_NE(message.find(model->joints()[0].name), std::string::npos);
}

TEST_F(LockstepTest, ConfigurationIsBaseThenJoints) {
  const Eigen::VectorXd q = robot.report.configuration();
  ASSERT_EQ(q.size(), model->dof());
  EXPECT_EQ(q(1), 2);
  EXPECT_NEAR(q(3), 0.5, 1e-12);
  EXPECT_NEAR(q(5), -0.1, 1e-12);
  EXPECT_EQ(q(6), robot.report.joints(0));
}

TEST(LockstepSettings, AreChecked) {
  LockstepSettings s;
  s.silent_after = 0.1;
  EXPECT_THROW(s.check(), Error);
}

}  // namespace
}  // namespace periplus::motion
