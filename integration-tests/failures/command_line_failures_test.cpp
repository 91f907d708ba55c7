// What the person at the terminal gets: exit status and a sentence that says what to do.
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <thread>

#include "common/core/file.h"
#include "common/dds/codec_impl.h"
#include "common/wire/common_wire.h"
#include "idl/posture.h"
#include "integration-tests/failures/supervised_run.h"

namespace periplus::failures {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

const fs::path kDeploy = fs::path(PERIPLUS_SOURCE_DIR) / "deploy";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// The program `periplus`, with what it says.
class Command {
 public:
  Command(SupervisedRun& run, const std::string& name, const std::vector<std::string>& arguments)
      : log_(run.bench.folder() + "/" + name + ".txt"),
        program_(std::string(PERIPLUS_BIN_DIR) + "/periplus", arguments,
                 {{"PERIPLUS_DOMAIN", std::to_string(run.bench.node().options().domain)},
                  {"XDG_STATE_HOME", run.bench.folder() + "/state"},
                  {"XDG_RUNTIME_DIR", run.bench.folder()}},
                 log_) {}
  harness::Program& program() { return program_; }
  int wait(std::chrono::seconds timeout = 40s) { return program_.wait(timeout).value_or(-1); }
  std::string said() const { return read_file(log_); }

 private:
  const std::string log_;
  harness::Program program_;
};

// `periplus run` against the scripted services.
class CommandLine : public testing::Test {
 protected:
  CommandLine() : run(testing::UnitTest::GetInstance()->current_test_info()->name()), task(run.bench.folder() + "/failures.yaml") {
    run.services.heartbeat();
    std::ofstream(task) << run.task();
  }
  ~CommandLine() override {
    if (HasFailure()) std::fputs(run.bench.logs().c_str(), stderr);
  }
  SupervisedRun run;
  const std::string task;
};

TEST_F(CommandLine, NbvRunsThePlannerOnFiles) {
  Command missing(run, "nbv", {"nbv", "absent.periplus", (kDeploy / "cameras/hrp2like-pair.yaml").string()});
  EXPECT_EQ(missing.wait(), 2);
  EXPECT_NE(missing.said().find("absent.periplus"), std::string::npos) << missing.said();
  Command help(run, "nbv-help", {"nbv", "--help"});
  EXPECT_EQ(help.wait(), 0);
  EXPECT_NE(help.said().find("--forbid"), std::string::npos) << help.said();
}

TEST_F(CommandLine, ARobotFaultIsExitStatus6WithItsReason) {
  run.services.fail("motion/walk", ErrorCode::motion_robot_fault, "the robot has fallen");
  Command command(run, "run", {"run", "--attach", task});
  EXPECT_EQ(command.wait(), 6) << command.said();
  EXPECT_NE(command.said().find("the robot has fallen"), std::string::npos) << command.said();
}

TEST_F(CommandLine, ControlCEndsWith130AndTheRobotHalts) {
  run.services.hold("motion/walk");
  Command command(run, "run", {"run", "--attach", task});
  ASSERT_TRUE(run.services.wait_for_call("motion/walk")) << command.said();
  command.program().signal(SIGINT);
  EXPECT_EQ(command.wait(), 130) << command.said();
  EXPECT_EQ(run.services.calls("motion/halt"), 1);
  EXPECT_NE(command.said().find("aborting"), std::string::npos) << command.said();
}

TEST_F(CommandLine, AbortEndsTheRunOfAnotherTerminalAndASecondRunIsRefused) {
  run.services.hold("motion/walk");
  Command first(run, "first", {"run", "--attach", task});
  ASSERT_TRUE(run.services.wait_for_call("motion/walk")) << first.said();
  Command second(run, "second", {"run", "--attach", task});
  EXPECT_EQ(second.wait(), 2) << second.said();
  EXPECT_NE(second.said().find("periplus abort"), std::string::npos) << second.said();
  Command wrong(run, "wrong", {"abort", "no-such-run"});
  EXPECT_EQ(wrong.wait(), 2) << wrong.said();
  EXPECT_TRUE(first.program().running());

  Command abort(run, "abort", {"abort"});
  EXPECT_EQ(abort.wait(), 0) << abort.said();
  EXPECT_EQ(first.wait(), 130) << first.said();
  EXPECT_EQ(run.services.calls("motion/halt"), 1);
}

TEST_F(CommandLine, AnObjectThatWasKnownIsSaidToBeBegunAnew) {
  run.services.promise(1);
  Command first(run, "first", {"run", "--attach", task});
  EXPECT_EQ(first.wait(), 0) << first.said();
  EXPECT_EQ(first.said().find("begun anew"), std::string::npos) << first.said();
  Command second(run, "second", {"run", "--attach", task});
  EXPECT_EQ(second.wait(), 0) << second.said();
  EXPECT_NE(second.said().find("object thing was known to the model server: it is begun anew"), std::string::npos) << second.said();
}

TEST_F(CommandLine, ASecondSupervisorIsRefused) {
  ASSERT_TRUE(run.abort("").ok());   // the first one is there
  harness::Program& second = run.bench.start("periplus-supervisor");
  EXPECT_EQ(second.wait(20s).value_or(-1), 2);
  const std::string said = run.bench.logs();
  EXPECT_NE(said.find("another supervisor"), std::string::npos) << said;
  EXPECT_NE(said.find("periplus down"), std::string::npos) << said;
  run.services.promise(1);
  EXPECT_EQ(run.run().status, 0);   // the first one is not disturbed
}

TEST(Supervisors, OfTwoThatStartTogetherExactlyOneStays) {
  harness::TestBench bench("two-supervisors");
  harness::Program& a = bench.start("periplus-supervisor");
  harness::Program& b = bench.start("periplus-supervisor");
  dds::RpcClient<msg::AbortRequest, msg::AbortReply> abort(bench.node(), "supervisor/abort");
  ASSERT_TRUE(abort.wait_for_server(15s)) << bench.logs();
  for (const auto end = std::chrono::steady_clock::now() + 10s; a.running() && b.running() && std::chrono::steady_clock::now() < end;)
    std::this_thread::sleep_for(20ms);
  EXPECT_NE(a.running(), b.running()) << bench.logs();
  EXPECT_EQ((a.running() ? b : a).wait(1s).value_or(-1), 2);
}

// A heartbeat of a supervisor of another container: the same process number may be its own, and its clock is hours late.
TEST(Supervisors, OneOfAnotherContainerIsRecognised) {
  harness::TestBench bench("other-container");
  dds::Publisher<msg::ServiceStatus> statuses(bench.node(), "periplus/service/status", dds::qos_latest(1));
  msg::ServiceStatus status;
  status.instance(std::string("supervisor-elsewhere-7-abcdef01"));
  status.service(std::string("supervisor"));
  status.state(1);
  status.wall_time_ns(1);
  statuses.publish(status);
  harness::Program& supervisor = bench.start("periplus-supervisor");
  EXPECT_EQ(supervisor.wait(20s).value_or(-1), 2) << bench.logs();
  EXPECT_NE(bench.logs().find("supervisor-elsewhere-7-abcdef01"), std::string::npos) << bench.logs();
}

// Files that cannot be used, each found before anything is started.
class BadFiles : public testing::Test {
 protected:
  BadFiles() : run(testing::UnitTest::GetInstance()->current_test_info()->name()), folder(run.bench.folder()) {
    run.bench.stop_all();
    task = read_file(kDeploy / "tasks/bunny-short.yaml");
    fs::create_directories(folder / "deploy");
    fs::copy(kDeploy / "robots", folder / "deploy/robots");
    fs::copy(kDeploy / "scenes", folder / "deploy/scenes");
  }
  // Exit status 2 at once, and what is said.
  std::string refusal(const std::string& task_text) {
    std::ofstream(folder / "task.yaml") << task_text;
    Command command(run, "check-" + std::to_string(++count), {"run", "--check", (folder / "task.yaml").string()});
    EXPECT_EQ(command.wait(20s), 2) << command.said();
    return command.said();
  }
  void edit(const std::string& file, const std::string& from, const std::string& to) {
    const std::string text = replaced(read_file(folder / file), from, to);
    std::ofstream(folder / file) << text;
  }
  void expect_says(const std::string& said, const std::vector<std::string>& words) {
    for (const std::string& word : words) EXPECT_NE(said.find(word), std::string::npos) << word << " in: " << said;
  }

  SupervisedRun run;
  const fs::path folder;
  std::string task;
  int count = 0;
};

TEST_F(BadFiles, TasksNameTheLineAndWhatIsExpected) {
  {
    std::ofstream(folder / "task.yaml") << task;
    Command good(run, "good", {"run", "--check", (folder / "task.yaml").string()});
    ASSERT_EQ(good.wait(20s), 0) << good.said();
  }
  expect_says(refusal(replaced(task, "box_center_m: [", "box_center_m: [[")), {"task.yaml:"});
  expect_says(refusal(replaced(task, "most_looks", "most_lokos")), {"task.yaml:", "most_lokos", "most_looks"});
  expect_says(refusal(replaced(task, "voxel_m: 0.02", "voxel_m: fine")), {"task.yaml:", "voxel_m", "number"});
  expect_says(refusal(replaced(task, "voxel_m: 0.02", "voxel_m: .nan")), {"task.yaml:", "voxel_m"});
  expect_says(refusal(replaced(task, "scenes/bunny.yaml", "scenes/nowhere.yaml")), {"task.yaml", "scene", "nowhere.yaml"});
  expect_says(refusal(replaced(task, "robots/hrp2like.yaml", "robots/nobody.yaml")), {"task.yaml", "robot", "nobody.yaml"});
}

TEST_F(BadFiles, RobotsAndScenesNameWhatIsMissing) {
  edit("deploy/robots/hrp2like.yaml", "  RLEG_JOINT2:", "  RLEG_JIONT2:");
  expect_says(refusal(task), {"hrp2like.yaml", "RLEG_JIONT2", "RLEG_JOINT2"});
  edit("deploy/robots/hrp2like.yaml", "  RLEG_JIONT2:", "  RLEG_JOINT2:");
  const std::string urdf = read_file(folder / "deploy/robots/hrp2like.urdf");
  std::ofstream(folder / "deploy/robots/hrp2like.urdf") << urdf.substr(0, urdf.size() / 2);
  expect_says(refusal(task), {"hrp2like"});
  std::ofstream(folder / "deploy/robots/hrp2like.urdf") << urdf;
  edit("deploy/scenes/bunny.yaml", "shape: box", "shape: bxo");
  expect_says(refusal(task), {"bunny.yaml", "bxo", "box"});
  edit("deploy/scenes/bunny.yaml", "shape: bxo", "shape: box");
  edit("deploy/scenes/bunny.yaml", "position_m: [0, 0, 0.35]", "position_m: [0, .inf, 0.35]");
  expect_says(refusal(task), {"bunny.yaml", "position_m"});
}

TEST_F(BadFiles, AMissingMeshIsFoundBeforeTheRunBegins) {
  edit("deploy/scenes/bunny.yaml", "mesh: bunny.obj", "mesh: hare.obj");
  std::ofstream(folder / "task.yaml") << task;
  Command command(run, "run", {"run", "--output", (folder / "runs").string(), (folder / "task.yaml").string()});
  EXPECT_EQ(command.wait(60s), 2) << command.said();
  expect_says(command.said(), {"hare.obj"});
  EXPECT_FALSE(fs::exists(folder / "runs")) << "something was started";
  expect_says(refusal(task), {"hare.obj"});
}

// Requests that are none: the posture generator's answers (the other services' own tests ask them).
TEST(BadRequests, PosesThatAreNoneAreRefused) {
  harness::TestBench bench("bad-requests");
  bench.start("periplus-posture-generator");
  dds::RpcClient<msg::PostureRequest, msg::PostureReply> client(bench.node(), "posture/generate");
  const auto refusal = [&](const std::function<void(msg::PostureRequest&)>& spoil, ErrorCode code) {
    msg::PostureRequest request;
    msg::PostureReply reply;
    request.posture_id("p");
    request.environment_revision(std::string(64, '0'));
    request.pose_world_camera(wire::to_wire(Pose::Identity()));
    spoil(request);
    const dds::RpcResult result = client.call(request, reply, {.deadline = 20s, .wait_for_server = 15s});
    EXPECT_EQ(result.status, dds::RpcStatus::ok);
    EXPECT_EQ(result.error_code, static_cast<int>(code)) << result.error_message;
    return result.error_message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(refusal([&](auto& q) { q.pose_world_camera().position().y(nan); }, ErrorCode::not_finite).empty());
  EXPECT_FALSE(refusal([&](auto& q) { q.pose_world_camera().qz(nan); }, ErrorCode::not_finite).empty());
  EXPECT_FALSE(refusal([&](auto& q) { q.pose_world_camera().qw(3); }, ErrorCode::bad_input).empty());
  EXPECT_NE(refusal([&](auto& q) { q.start({0, nan}); }, ErrorCode::not_finite).find("start"), std::string::npos);
  EXPECT_NE(refusal([&](auto& q) { q.object_id("a b"); }, ErrorCode::bad_input).find("object_id"), std::string::npos);
  EXPECT_FALSE(refusal([](auto& q) { q.environment_revision(std::string()); }, ErrorCode::bad_input).empty());
  EXPECT_NE(refusal([](auto&) {}, ErrorCode::posture_revision_not_here).find("model/publish"), std::string::npos);
}

}  // namespace
}  // namespace periplus::failures
