#include "services/supervisor/cli/run_command.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/core/error.h"

namespace periplus::supervisor::cli {
namespace {

const std::string kTask = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/tasks/bunny.yaml";

TEST(RunCommand, CheckReadsWithoutStartingAnything) {
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_task({.task = kTask, .overrides = {}, .output = "", .check = true}), 0);
  EXPECT_NE(testing::internal::GetCapturedStdout().find("are good"), std::string::npos);
  try {
    run_task({.task = kTask, .overrides = {"voxel_m=-1"}, .output = "", .check = true});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    EXPECT_NE(std::string(e.what()).find("voxel_m"), std::string::npos);
  }
}

TEST(RunCommand, CheckMissesTheObjectsMesh) {
  const auto folder = std::filesystem::temp_directory_path() / ("periplus_no_assets_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  ::setenv("PERIPLUS_ASSETS", folder.c_str(), 1);
  try {
    run_task({.task = kTask, .overrides = {}, .output = "", .check = true});
    ADD_FAILURE() << "called good";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::io);
    EXPECT_NE(std::string(e.what()).find(folder.string()), std::string::npos) << e.what();
  }
  ::unsetenv("PERIPLUS_ASSETS");
  std::filesystem::remove_all(folder);
}

TEST(RunCommand, DownWithNobodyUpIsNoError) {
  const auto folder = std::filesystem::temp_directory_path() / ("periplus_run_command_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  ::setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
  testing::internal::CaptureStdout();
  EXPECT_EQ(down(), 0);
  EXPECT_NE(testing::internal::GetCapturedStdout().find("nothing of this user"), std::string::npos);
  ::unsetenv("XDG_RUNTIME_DIR");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace periplus::supervisor::cli
