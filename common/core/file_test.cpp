#include "common/core/file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/core/error.h"

namespace periplus {
namespace {

ErrorCode reading(const std::string& path, std::uint64_t most_bytes) {
  try {
    read_file(path, most_bytes);
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
    return error.code();
  }
  return ErrorCode::ok;
}

TEST(File, WholeFilesComeAsTheyAre) {
  const std::string path = testing::TempDir() + "file_test.bin";
  std::string bytes(200000, 'a');
  bytes[100000] = '\0';
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_EQ(read_file(path), bytes);
  EXPECT_EQ(reading(path, bytes.size()), ErrorCode::ok);
  EXPECT_EQ(reading(path, bytes.size() - 1), ErrorCode::bad_size);
  std::ofstream(path, std::ios::binary) << "";
  EXPECT_EQ(read_file(path), "");
  std::filesystem::remove(path);
}

TEST(File, MissingOnesAndFoldersAreRefused) {
  EXPECT_EQ(reading(testing::TempDir() + "file_test.missing", 10), ErrorCode::io);
  EXPECT_EQ(reading(testing::TempDir(), 10), ErrorCode::io);
}

}  // namespace
}  // namespace periplus
