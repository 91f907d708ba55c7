#include "common/mesh/assets.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"

namespace periplus::mesh {
namespace {

TEST(Assets, FoundInTheFolderNamedByTheEnvironment) {
  const auto folder = std::filesystem::temp_directory_path() / ("assets_test-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder / "own");
  std::ofstream(folder / "a.obj") << "x";
  std::ofstream(folder / "own" / "a.obj") << "y";
  setenv("PERIPLUS_ASSETS", folder.c_str(), 1);
  EXPECT_EQ(assets_folder(), folder.string());
  EXPECT_EQ(find_asset("a.obj"), (folder / "a.obj").string());
  EXPECT_EQ(find_asset("a.obj", {(folder / "own").string()}), (folder / "own" / "a.obj").string());
  EXPECT_EQ(find_asset((folder / "a.obj").string()), (folder / "a.obj").string());
  try {
    find_asset("b.obj");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::io);
    EXPECT_NE(std::string(e.what()).find(folder.string()), std::string::npos);
  }
  unsetenv("PERIPLUS_ASSETS");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace periplus::mesh
