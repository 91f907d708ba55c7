#include "common/core/locate.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <fstream>

namespace periplus {
namespace {

TEST(Locate, TheFolderOfTheEnvironmentComesFirst) {
  const auto folder = std::filesystem::temp_directory_path() / ("periplus_locate_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "walk_planner.yaml") << "a: 1\n";
  ::setenv("PERIPLUS_CONFIG_DIR", folder.c_str(), 1);
  ::setenv("PERIPLUS_SHARE_DIR", folder.c_str(), 1);
  EXPECT_EQ(default_configuration("walk_planner"), folder / "walk_planner.yaml");
  ASSERT_FALSE(share_folders().empty());
  EXPECT_EQ(share_folders().front(), folder);
  ::unsetenv("PERIPLUS_CONFIG_DIR");
  ::unsetenv("PERIPLUS_SHARE_DIR");
  EXPECT_NE(default_configuration("walk_planner"), folder / "walk_planner.yaml");
  std::filesystem::remove_all(folder);
}

TEST(Locate, AServiceThatDoesNotExistHasNoConfiguration) { EXPECT_TRUE(default_configuration("no_such_service").empty()); }

TEST(Locate, KnowsItsOwnFolder) { EXPECT_TRUE(std::filesystem::exists(executable_folder() / "core_test")); }

}  // namespace
}  // namespace periplus
