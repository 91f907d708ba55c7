#include "integration-tests/harness/program.h"

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <memory>

#include "common/core/error.h"
#include "common/core/file.h"

namespace periplus::harness {
namespace {

using namespace std::chrono_literals;

TEST(Program, GivesItsStatusAndOutputAndHasItsEnvironment) {
  const std::string log = testing::TempDir() + "program_test.log";
  std::filesystem::remove(log);
  Program p("/bin/sh", {"-c", "echo $GREETING; echo oops >&2; exit 7"}, {{"GREETING", "hello"}}, log);
  EXPECT_EQ(p.wait(10s), 7);
  EXPECT_FALSE(p.running());
  EXPECT_EQ(read_file(log), "hello\noops\n");
}

TEST(Program, CanBeKilledAndIsGoneAfterItsLife) {
  auto p = std::make_unique<Program>("/bin/sleep", std::vector<std::string>{"60"}, Program::Environment{}, "/dev/null");
  EXPECT_TRUE(p->running());
  EXPECT_EQ(p->wait(20ms), std::nullopt);
  p->signal(SIGKILL);
  EXPECT_EQ(p->wait(10s), 128 + SIGKILL);
  p = std::make_unique<Program>("/bin/sleep", std::vector<std::string>{"60"}, Program::Environment{}, "/dev/null");
  const pid_t pid = p->pid();
  p.reset();
  EXPECT_NE(::kill(pid, 0), 0);
}

TEST(Program, SaysWhatCannotBeStarted) { EXPECT_THROW(Program("/nowhere/at/all", {}, {}, "/dev/null"), Error); }

}  // namespace
}  // namespace periplus::harness
