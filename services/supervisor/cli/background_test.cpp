#include "services/supervisor/cli/background.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <fstream>

namespace periplus::supervisor::cli {
namespace {

class BackgroundTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("periplus_background_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    ::setenv("XDG_RUNTIME_DIR", folder_.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("XDG_RUNTIME_DIR");
    std::filesystem::remove_all(folder_);
  }
  std::filesystem::path folder_;
};

TEST_F(BackgroundTest, TheKeeperIsFoundWhileItLives) {
  EXPECT_FALSE(find_background(7));
  {
    BackgroundRecord record(7, "/some/logs");
    const auto found = find_background(7);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->pid, ::getpid());
    EXPECT_EQ(found->logs, "/some/logs");
    EXPECT_FALSE(find_background(8));
  }
  EXPECT_FALSE(find_background(7));
}

TEST_F(BackgroundTest, ARecordOfADeadOrAnotherProcessIsRemoved) {
  const auto file = background_folder() / "domain-7.yaml";
  std::ofstream(file) << "pid: " << ::getpid() << "\nstart_ticks: 1\nlogs: x\n";
  EXPECT_FALSE(find_background(7));
  EXPECT_FALSE(std::filesystem::exists(file));
  std::ofstream(file) << "pid: ";
  EXPECT_FALSE(find_background(7));
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace periplus::supervisor::cli
