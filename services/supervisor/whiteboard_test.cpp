#include "services/supervisor/whiteboard.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"

namespace periplus::supervisor {
namespace {

TEST(Whiteboard, EveryLineStandsOnDiskBeforeTheCallReturns) {
  const std::string path = testing::TempDir() + "/whiteboard_test.jsonl";
  std::filesystem::remove(path);
  Whiteboard board(path);
  EXPECT_TRUE(board.get("feet").is_null());
  board.entered("walk", "footsteps \"quoted\"", 3);
  board.put("feet", {{"left", {1.5, 2.0, 0.1}}});
  board.put("feet", {{"left", {1.0, 2.0, 0.1}}});
  EXPECT_EQ(board.get("feet")["left"][0], 1.0);
  std::ifstream file(path);
  std::string line;
  std::vector<nlohmann::json> lines;
  while (std::getline(file, line)) lines.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0]["state"], "walk");
  EXPECT_EQ(lines[0]["cause"], "footsteps \"quoted\"");
  EXPECT_EQ(lines[0]["look"], 3);
  EXPECT_EQ(lines[1]["value"]["left"][0], 1.5);
}

TEST(Whiteboard, SaysWhatItCannotWrite) { EXPECT_THROW(Whiteboard("/no/such/folder/w.jsonl"), Error); }

TEST(Time, Iso) { EXPECT_EQ(iso_time(1000000000123456789LL), "2001-09-09T01:46:40.123Z"); }

}  // namespace
}  // namespace periplus::supervisor
