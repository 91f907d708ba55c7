// The whole system with a robot that fails: the simulator's own faults, and a run aborted in mid-walk.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

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
  ASSERT_TRUE(run.wait_for_state("walk")) << run.output();
  run.interrupt();
  const RunResult result = run.finish(90s);
  ASSERT_TRUE(result.status.has_value()) << "it hung: " << result.output;
  EXPECT_EQ(*result.status, 130) << result.output;
  EXPECT_TRUE(result.went("walk", "halt")) << result.output;
  EXPECT_TRUE(result.went("halt", "aborted"));
}

}  // namespace
}  // namespace periplus::failures
