#include "common/service/service.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/dds/testing/test_domain.h"
#include "idl/common.h"

namespace periplus::service {
namespace {

using namespace std::chrono_literals;

class Run : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "LP_NUM_THREADS"}) ::setenv(name, "1", 1);
    folder_ = std::filesystem::temp_directory_path() / ("periplus_service_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    ::setenv("PERIPLUS_CONFIG_DIR", folder_.c_str(), 1);
    std::ofstream(folder_ / "tester.yaml") << "range_m: 2.5\nsearch:\n  count: 4\n";
  }
  void TearDown() override {
    log::configure({});
    std::filesystem::remove_all(folder_);
    ::unsetenv("PERIPLUS_CONFIG_DIR");
  }

  struct Settings {
    double range = 0;
    int count = 0;
  };
  // Runs with `arguments`; the body reads the settings.
  int run_with(std::vector<std::string> arguments, Settings* settings = nullptr) {
    arguments.insert(arguments.begin(), "tester");
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    output_.clear();
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status = service::run(static_cast<int>(argv.size()) - 1, argv.data(), {.name = "tester", .summary = "for tests", .options = {}},
                                    [&](Service& service) {
                                      Settings read;
                                      service.configuration().read("range_m", read.range, {.minimum = 0});
                                      const config::Node search = service.configuration().child("search");
                                      search.read("count", read.count);
                                      service.configuration().finish();
                                      if (settings) *settings = read;
                                      if (!service.check_only()) throw Error(ErrorCode::internal, "a defect");
                                    });
    output_ = testing::internal::GetCapturedStdout();
    errors_ = testing::internal::GetCapturedStderr();
    return status;
  }

  std::filesystem::path folder_;
  std::string output_, errors_;
};

TEST_F(Run, ReadsDefaultsFileAndOverridesInThisOrder) {
  Settings settings;
  EXPECT_EQ(run_with({"--check"}, &settings), 0) << errors_;
  EXPECT_EQ(settings.range, 2.5);
  EXPECT_EQ(settings.count, 4);
  std::ofstream(folder_ / "mine.yaml") << "range_m: 3\nsearch: {count: 5}\n";
  EXPECT_EQ(run_with({"--check", "--config", folder_ / "mine.yaml", "--set", "search.count=6"}, &settings), 0) << errors_;
  EXPECT_EQ(settings.range, 3);
  EXPECT_EQ(settings.count, 6);
}

TEST_F(Run, PrintsTheConfiguration) {
  EXPECT_EQ(run_with({"--print-config", "--set", "search.count=6"}), 0);
  EXPECT_EQ(output_, "range_m: 2.5\nsearch:\n  count: 6\n");
}

TEST_F(Run, BadInputIsStatus2WithOneSentence) {
  EXPECT_EQ(run_with({"--check", "--set", "search.cuont=6"}), 2);
  EXPECT_NE(errors_.find("search.cuont: unknown key; the nearest known one is 'count'"), std::string::npos) << errors_;
  EXPECT_EQ(run_with({"--check", "--set", "range_m=-1"}), 2);
  EXPECT_EQ(run_with({"--check", "--set", "range_m"}), 2);
  EXPECT_EQ(run_with({"--check", "--config", "/no/such.yaml"}), 2);
  EXPECT_EQ(run_with({"--log-level", "loud"}), 2);
  EXPECT_EQ(run_with({"--no-such-option"}), 2);
}

TEST_F(Run, VersionAndHelpEndWell) {
  EXPECT_EQ(run_with({"--version"}), 0);
  EXPECT_NE(output_.find("tester "), std::string::npos);
  EXPECT_EQ(run_with({"--help"}), 0);
  EXPECT_NE(output_.find("--print-config"), std::string::npos);
}

TEST_F(Run, OtherFailuresAreStatus1AndInTheLog) {
  const std::string file = folder_ / "log.jsonl";
  EXPECT_EQ(run_with({"--log-file", file}), 1);
  std::ifstream in(file);
  std::string line;
  ASSERT_TRUE(std::getline(in, line));
  EXPECT_NE(line.find("\"message\":\"a defect\""), std::string::npos) << line;
  EXPECT_NE(errors_.find("a defect"), std::string::npos);
}

TEST_F(Run, BeatsUntilSigtermAndSaysGoodBye) {
  const dds::testing::TestDomain domain;
  ::setenv("PERIPLUS_DOMAIN", std::to_string(domain.id()).c_str(), 1);
  std::mutex mutex;
  std::vector<int> states;
  std::string detail;
  std::atomic<int> metrics{0};
  std::atomic<bool> body_ended{false};
  // A program has no threads before run(); here the watcher's must not take the signal.
  sigset_t terminate;
  sigemptyset(&terminate);
  sigaddset(&terminate, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &terminate, nullptr);
  auto watcher = dds::Node::create(dds::NodeOptions::from_environment("watcher"));
  dds::Subscriber<msg::ServiceStatus> status(*watcher, "periplus/service/status", dds::qos_latest(), [&](const msg::ServiceStatus& s) {
    const std::lock_guard lock(mutex);
    if (states.empty() || states.back() != s.state()) states.push_back(s.state());
    if (s.state() == 0 && !s.detail().to_string().empty()) detail = s.detail().to_string();
  });
  dds::Subscriber<msg::ServiceMetrics> measured(*watcher, "periplus/service/metrics", dds::qos_latest(), [&](const msg::ServiceMetrics& m) {
    if (m.rpcs().size() == 1 && m.rpcs()[0].calls() == 7) ++metrics;
  });
  std::string program = "tester";
  char* argv[] = {program.data(), nullptr};
  const int result = service::run(1, argv, {.name = "tester", .summary = "for tests", .options = {}}, [&](Service& service) {
    service.configuration().keys();
    service.node();
    service.waiting_for("the cameras");
    service.add_statistics([] { return dds::RpcStatistics{.name = "x/y", .calls = 7}; });
    std::this_thread::sleep_for(1500ms);
    service.ready();
    EXPECT_FALSE(service.wait_until_stopped(1500ms));
    ::kill(::getpid(), SIGTERM);
    service.wait_until_stopped();
    EXPECT_TRUE(service.stopping());
    body_ended = true;
  });
  EXPECT_EQ(result, 0);
  EXPECT_TRUE(body_ended);
  for (int i = 0; i < 40; ++i) {
    std::this_thread::sleep_for(50ms);
    const std::lock_guard lock(mutex);
    if (!states.empty() && states.back() == 4) break;
  }
  const std::lock_guard lock(mutex);
  ASSERT_FALSE(states.empty());
  EXPECT_EQ(states.front(), 0);
  EXPECT_EQ(states.back(), 4);
  EXPECT_NE(std::find(states.begin(), states.end(), 1), states.end());
  EXPECT_EQ(detail, "waiting for the cameras");
  EXPECT_GE(metrics, 1);
  ::unsetenv("PERIPLUS_DOMAIN");
}

}  // namespace
}  // namespace periplus::service
