#include "services/supervisor/supervisor_service.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <string>

#include "common/core/testing/no_threads.h"
#include "common/dds/codec_impl.h"
#include "common/service/testing/test_service.h"
#include "common/wire/common_wire.h"
#include "idl/supervisor.h"

namespace periplus::supervisor {
namespace {

using namespace std::chrono_literals;

// Removed with all in it when its user is gone.
struct Folder {
  ~Folder() { std::filesystem::remove_all(path); }
  const std::filesystem::path path = std::filesystem::temp_directory_path() / ("periplus_supervisor_service_test_" + std::to_string(::getpid()));
};

// A supervisor whose runs end at once, as they name no robot.
class AloneSupervisor : public testing::Test {
 protected:
  static SupervisorSettings settings() {
    SupervisorSettings s;
    s.wait_for_service_s = 0;
    return s;
  }
  ErrorCode begin(const std::string& run_id) {
    msg::StartRequest q;
    q.run_id(run_id);
    q.task_yaml(wire::text_to_wire("schema: 1\nname: t\nrobot: r.yaml\nscene: s.yaml\noutput: " + folder.path.string() +
                                   "\nobject: {id: o, box_center_m: [0, 0, 1], box_size_m: [0.5, 0.5, 0.5], box_yaw_rad: 0}\n"));
    msg::StartReply r;
    return static_cast<ErrorCode>(start.call(q, r, {.deadline = 60s, .wait_for_server = 10s}).error_code);
  }

  const Folder folder;
  service::testing::TestService service{"supervisor"};
  SupervisorService supervisor{service, settings()};
  dds::RpcClient<msg::StartRequest, msg::StartReply> start{service.node(), "supervisor/start"};
};

TEST_F(AloneSupervisor, WhoHearsOfTheEndBeginsTheNextRun) {
  std::atomic<int> ended{0};
  dds::Subscriber<msg::RunEvent> events(service.node(), "periplus/supervisor/event", dds::qos_latest(256), [&](const msg::RunEvent& e) {
    if (e.kind().to_string() != "end") return;
    ++ended;
    ended.notify_all();
  });
  constexpr int kRuns = 20;
  for (int n = 0; n < kRuns; ++n) {
    ASSERT_EQ(begin("run-" + std::to_string(n)), ErrorCode::ok) << n;
    ended.wait(n);
  }
  EXPECT_EQ(ended, kRuns);
}

// The supervisor is free for the next one.
TEST_F(AloneSupervisor, ARunThatCouldNotBeginIsNotUnderWay) {
  {
    const NoThreads none;
    EXPECT_EQ(begin("first"), ErrorCode::internal);
  }
  EXPECT_EQ(begin("second"), ErrorCode::ok);
}

}  // namespace
}  // namespace periplus::supervisor
