// The whole system with a robot that fails: the simulator's own faults, and a run aborted in mid-walk.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>
#include <thread>

#include "common/core/clock.h"
#include "common/dds/codec_impl.h"
#include "common/dds/node.h"
#include "idl/sim.h"
#include "integration-tests/scenarios/run_fixture.h"

namespace periplus::failures {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;
using scenarios::SystemRun;
using scenarios::RunResult;

// The simulator's configuration with one fault switched on, in a folder of its own.
class SpoiltSimulator {
 public:
  SpoiltSimulator(const std::string& line, const std::string& instead)
      : folder_(fs::temp_directory_path() / ("periplus-spoilt-" + std::to_string(::getpid()))) {
    std::ifstream in(fs::path(PERIPLUS_SOURCE_DIR) / "services/simulator/config/default.yaml");
    std::ostringstream text;
    text << in.rdbuf();
    std::string yaml = text.str();
    const std::size_t at = yaml.find(line);
    EXPECT_NE(at, std::string::npos) << line;
    if (at != std::string::npos) yaml.replace(at, line.size(), instead);
    fs::create_directories(folder_);
    std::ofstream(folder_ / "simulator.yaml") << yaml;
  }
  ~SpoiltSimulator() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  std::map<std::string, std::string> environment() const { return {{"PERIPLUS_CONFIG_DIR", folder_.string()}}; }

 private:
  const fs::path folder_;
};

// The robot's states as the simulator publishes them, one for each command.
class RobotWatch {
 public:
  explicit RobotWatch(int domain) : node_(dds::Node::create(options(domain))), states_(*node_, "periplus/robot/state", dds::qos_stream(64), [this](const msg::RobotState& s) {
      const std::lock_guard lock(mutex_);
      last_ = s;
      last_wall_time_ns_ = wall_time_ns();
    }) {}
  msg::RobotState last() const {
    const std::lock_guard lock(mutex_);
    return last_;
  }
  // When the last one came.
  std::int64_t last_wall_time_ns() const {
    const std::lock_guard lock(mutex_);
    return last_wall_time_ns_;
  }
  // True once a foot was seen this high [m].
  bool wait_for_foot_above(double height) const {
    for (const auto end = std::chrono::steady_clock::now() + 60s; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(1ms)) {
      const msg::RobotState now = last();
      if (std::max(now.pose_world_left_foot().position().z(), now.pose_world_right_foot().position().z()) > height) return true;
    }
    return false;
  }

 private:
  static dds::NodeOptions options(int domain) {
    dds::NodeOptions o;
    o.name = "robot-watch";
    o.domain = domain;
    return o;
  }
  mutable std::mutex mutex_;
  msg::RobotState last_;
  std::int64_t last_wall_time_ns_ = 0;
  const std::shared_ptr<dds::Node> node_;
  const dds::Subscriber<msg::RobotState> states_;
};

void expect_end(const RunResult& result, int status, const std::string& reason, const std::string& state_before) {
  ASSERT_TRUE(result.status.has_value()) << "it hung: " << result.output;
  EXPECT_EQ(*result.status, status) << result.output;
  ASSERT_FALSE(result.report.is_null()) << result.output;
  EXPECT_EQ(result.report.at("exit").at("status"), status);
  const std::string why = result.report.at("exit").at("reason");
  EXPECT_NE(why.find(reason), std::string::npos) << why;
  EXPECT_NE(result.output.find(reason), std::string::npos) << result.output;
  const auto names = result.state_names();
  ASSERT_GE(names.size(), 2u);
  EXPECT_EQ(names[names.size() - 2], state_before);
}

TEST(RobotFailures, ABlankRightEyeEndsWithItsReason) {
  const SpoiltSimulator spoilt("blank_right_eye: false", "blank_right_eye: true");
  SystemRun run({.changes = {"truth=false"}, .environment = spoilt.environment()});
  const RunResult result = run.finish(90s);
  expect_end(result, 6, "right eye", "process_images");
  EXPECT_TRUE(result.report.at("looks").empty());   // nothing was made up
}

TEST(RobotFailures, AFallWhileWalkingEnds) {
  const SpoiltSimulator spoilt("fall_at_tick: 0", "fall_at_tick: 200");
  SystemRun run({.changes = {"truth=false"}, .environment = spoilt.environment()});
  const RunResult result = run.finish(120s);
  expect_end(result, 6, "fallen", "walk");
}

TEST(RobotFailures, ControlCInMidWalkHaltsTheRobot) {
  SystemRun run({.changes = {"truth=false"}});   // what was made is not evaluated
  const RobotWatch robot(run.domain());
  ASSERT_TRUE(run.wait_for_state("walk")) << run.output();
  ASSERT_TRUE(robot.wait_for_foot_above(0.02)) << run.output();
  run.interrupt();
  const RunResult result = run.finish(90s);
  ASSERT_TRUE(result.status.has_value()) << "it hung: " << result.output;
  EXPECT_EQ(*result.status, 130) << result.output;
  EXPECT_TRUE(result.went("walk", "halt")) << result.output;
  EXPECT_TRUE(result.went("halt", "aborted"));
  // It stands on both feet, at rest, and was commanded no more once the halt was done: the state that follows each command
  // is the last one that came.
  const msg::RobotState stands = robot.last();
  EXPECT_FALSE(stands.fallen());
  for (const msg::Pose& sole : {stands.pose_world_left_foot(), stands.pose_world_right_foot()}) {
    EXPECT_NEAR(sole.position().z(), 0, 1e-4);
    EXPECT_NEAR(std::hypot(sole.qx(), sole.qy()), 0, 1e-4) << "not flat on the floor";
  }
  ASSERT_FALSE(stands.velocities().empty());
  for (const double speed : stands.velocities()) EXPECT_NEAR(speed, 0, 1e-3);
  ASSERT_FALSE(result.states.empty());
  EXPECT_EQ(result.states.back().state, "aborted");
  EXPECT_LT(robot.last_wall_time_ns(), result.states.back().wall_time_ns);
}

}  // namespace
}  // namespace periplus::failures
