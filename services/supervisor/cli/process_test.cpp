#include "services/supervisor/cli/process.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "common/core/error.h"

namespace periplus::supervisor::cli {
namespace {

using namespace std::chrono_literals;

ProcessOptions shell(const std::string& script) { return {.program = "/bin/sh", .arguments = {"-c", script}, .environment = {}, .output = {}}; }

TEST(Process, TellsItsExitStatus) {
  Process ended(shell("exit 7"));
  EXPECT_EQ(ended.wait(5s), 7);
  Process killed(shell("kill -9 $$"));
  EXPECT_EQ(killed.wait(5s), 128 + 9);
}

TEST(Process, GetsItsEnvironmentAndItsOutputIsKept) {
  EXPECT_EQ(output_of("/bin/sh", {"-c", "echo hello"}), "hello\n");
  const std::string file = testing::TempDir() + "/periplus_process_test_" + std::to_string(::getpid());
  ProcessOptions options = shell("echo $PERIPLUS_DDS >&2; echo $PERIPLUS_DDS");
  options.environment = {{"PERIPLUS_DDS", "cyclonedds"}};
  options.output = file;
  Process process(options);
  EXPECT_EQ(process.wait(5s), 0);
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "cyclonedds");
  std::getline(in, line);
  EXPECT_EQ(line, "cyclonedds");
  std::filesystem::remove(file);
}

TEST(Process, AnAbsentProgramIsAnError) {
  EXPECT_THROW(Process({.program = "/no/such/program", .arguments = {}, .environment = {}, .output = {}}), Error);
  EXPECT_EQ(output_of("/no/such/program", {}), std::nullopt);
  EXPECT_EQ(output_of("/bin/sh", {"-c", "exit 1"}), std::nullopt);
}

TEST(Process, KillTakesGrandchildrenToo) {
  const std::string file = testing::TempDir() + "/periplus_grandchild_" + std::to_string(::getpid());
  pid_t grandchild = 0;
  {
    Process process(shell("sleep 100 & echo $! > " + file + "; wait"));
    for (int i = 0; i < 500 && !grandchild; ++i) {
      std::this_thread::sleep_for(10ms);
      std::ifstream(file) >> grandchild;
    }
    ASSERT_GT(grandchild, 0);
    EXPECT_TRUE(start_ticks(grandchild));
    EXPECT_FALSE(process.poll());
  }
  for (int i = 0; i < 200 && start_ticks(grandchild); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_FALSE(start_ticks(grandchild));
  std::filesystem::remove(file);
}

TEST(Process, KeepsItsNumberUntilItsGroupWasKilled) {
  const std::string file = testing::TempDir() + "/periplus_orphan_" + std::to_string(::getpid());
  Process process(shell("sleep 100 & echo $! > " + file));
  ASSERT_EQ(process.wait(5s), 0);
  pid_t orphan = 0;
  std::ifstream(file) >> orphan;
  ASSERT_TRUE(start_ticks(orphan));
  const std::string leader = "/proc/" + std::to_string(process.pid());
  EXPECT_TRUE(std::filesystem::exists(leader)) << "reaped: kill() would strike whoever has the number next";
  EXPECT_FALSE(start_ticks(process.pid())) << "though it has ended";
  process.kill();
  EXPECT_FALSE(std::filesystem::exists(leader));
  EXPECT_EQ(process.poll(), 0);
  for (int i = 0; i < 200 && start_ticks(orphan); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_FALSE(start_ticks(orphan));
  process.kill();  // once more is once too often for nobody
  std::filesystem::remove(file);
}

TEST(Process, TerminateIsAPoliteRequest) {
  Process process(shell("trap 'exit 3' TERM; while :; do sleep 0.02; done"));
  std::this_thread::sleep_for(200ms);
  process.terminate();
  EXPECT_EQ(process.wait(5s), 3);
}

TEST(Process, StartTicksNameALivingProcess) {
  EXPECT_TRUE(start_ticks(::getpid()));
  EXPECT_FALSE(start_ticks(0));
}

}  // namespace
}  // namespace periplus::supervisor::cli
