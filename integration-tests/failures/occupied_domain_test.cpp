// `periplus up` keeps the services of one scene; a task of another scene must not be run with them.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>

#include "common/core/file.h"
#include "common/dds/testing/test_domain.h"
#include "integration-tests/harness/program.h"

namespace periplus::failures {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

class OccupiedDomain : public testing::Test {
 protected:
  OccupiedDomain() { fs::create_directories(folder); }
  ~OccupiedDomain() override { fs::remove_all(folder); }

  std::unique_ptr<harness::Program> periplus(const std::string& verb, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), verb);
    arguments.insert(arguments.end(), {"-o", (folder / "runs").string()});
    return std::make_unique<harness::Program>(std::string(PERIPLUS_BIN_DIR) + "/periplus", arguments,
                                              harness::Program::Environment{{"PERIPLUS_DOMAIN", std::to_string(domain.id())},
                                                                            {"XDG_STATE_HOME", folder.string()},
                                                                            {"XDG_RUNTIME_DIR", folder.string()}},
                                              (folder / (verb + ".txt")).string());
  }
  std::string said(const std::string& verb) const { return read_file(folder / (verb + ".txt")); }
  static std::string task(const std::string& name) { return PERIPLUS_SOURCE_DIR "/deploy/tasks/" + name + ".yaml"; }

  const dds::testing::TestDomain domain;
  const fs::path folder = fs::temp_directory_path() / ("periplus-occupied-" + std::to_string(::getpid()));
};

TEST_F(OccupiedDomain, ATaskOfAnotherSceneIsRefused) {
  const auto up = periplus("up", {task("bunny-short")});
  const auto run = periplus("run", {"--attach", task("forbidden")});
  EXPECT_EQ(run->wait(60s).value_or(-1), 2) << said("run") << said("up");
  EXPECT_NE(said("run").find("the robot stands in scene bunny, which is not the task's scene forbidden"), std::string::npos) << said("run");
  EXPECT_TRUE(up->running()) << said("up");
  up->signal(SIGINT);
  EXPECT_TRUE(up->wait(20s));
}

}  // namespace
}  // namespace periplus::failures
