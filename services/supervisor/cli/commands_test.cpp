#include "services/supervisor/cli/commands.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <fstream>

namespace periplus::supervisor::cli {
namespace {

class Commands : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("periplus_commands_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_ / "other");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void program(const std::filesystem::path& file, bool executable) {
    std::ofstream(file) << "#!/bin/sh\n";
    if (executable) std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  std::filesystem::path folder_;
};

TEST_F(Commands, FindsProgramsBesideItselfFirstThenOnThePath) {
  const std::string path = ::getenv("PATH");
  ::setenv("PATH", (folder_ / "other").c_str(), 1);
  program(folder_ / "other" / "periplus-nbv", true);
  EXPECT_EQ(find_program("nbv", folder_), folder_ / "other" / "periplus-nbv");
  program(folder_ / "periplus-nbv", true);
  EXPECT_EQ(find_program("nbv", folder_), folder_ / "periplus-nbv");
  program(folder_ / "periplus-text", false);
  EXPECT_TRUE(find_program("text", folder_).empty());
  EXPECT_TRUE(find_program("../nbv", folder_ / "other").empty());
  EXPECT_TRUE(find_program("", folder_).empty());
  ::setenv("PATH", path.c_str(), 1);
}

TEST_F(Commands, SuggestsTheNearestVerb) {
  EXPECT_NE(no_such_command("dcotor", {"down", "doctor", "status"}).find("did you mean 'doctor'"), std::string::npos);
}

TEST_F(Commands, ErrorsHaveTheirExitStatus) {
  EXPECT_EQ(exit_status_of(ErrorCode::bad_input), 2);
  EXPECT_EQ(exit_status_of(ErrorCode::supervisor_busy), 2);
  EXPECT_EQ(exit_status_of(ErrorCode::supervisor_service_lost), 5);
  EXPECT_EQ(exit_status_of(ErrorCode::cancelled), 130);
  EXPECT_EQ(exit_status_of(ErrorCode::internal), 1);
}

TEST_F(Commands, RunsAreFoundByPath) {
  EXPECT_EQ(find_run(folder_), folder_);
  EXPECT_THROW(find_run((folder_ / "absent").string()), Error);
}

TEST_F(Commands, KnowsWhatIsAskedOfTheDatabase) {
  EXPECT_TRUE(is_of_database({"model", "list"}));
  EXPECT_TRUE(is_of_database({"model", "verify", "--recarve"}));
  EXPECT_TRUE(is_of_database({"model", "export", "ball", "--store", "somewhere"}));
  EXPECT_TRUE(is_of_database({"model", "digest", "--store=somewhere"}));
  EXPECT_FALSE(is_of_database({"model", "export", "ball"}));
  EXPECT_FALSE(is_of_database({"model", "digest"}));
  EXPECT_FALSE(is_of_database({"model", "--help"}));
  EXPECT_FALSE(is_of_database({"model"}));
  EXPECT_FALSE(is_of_database({"status"}));
}

}  // namespace
}  // namespace periplus::supervisor::cli
