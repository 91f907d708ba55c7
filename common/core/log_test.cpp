#include "common/core/log.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "common/core/error.h"

namespace periplus::log {
namespace {

class Log : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("periplus_log_test_" + std::to_string(::getpid()));
    std::filesystem::remove_all(folder_);
    file_ = folder_ / "deep" / "log.jsonl";
  }
  void TearDown() override {
    configure({});
    std::filesystem::remove_all(folder_);
  }
  std::vector<std::string> lines() const {
    std::ifstream in(file_);
    std::vector<std::string> all;
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
  std::filesystem::path folder_, file_;
};

TEST_F(Log, WritesOneJsonObjectALine) {
  configure({.service = "walk_planner", .file = file_, .console = false});
  info("planned \"well\"\n", {{"steps", "12"}, {"level", "floor"}});
  const auto all = lines();
  ASSERT_EQ(all.size(), 1u);
  const YAML::Node node = YAML::Load(all[0]);  // JSON is YAML
  EXPECT_EQ(node["level"].as<std::string>(), "info");
  EXPECT_EQ(node["service"].as<std::string>(), "walk_planner");
  EXPECT_EQ(node["message"].as<std::string>(), "planned \"well\"\n");
  EXPECT_EQ(node["steps"].as<std::string>(), "12");
  EXPECT_EQ(node["level_"].as<std::string>(), "floor");
  EXPECT_EQ(node["pid"].as<int>(), ::getpid());
  EXPECT_EQ(node["time"].as<std::string>().size(), 27u);
}

TEST_F(Log, KeepsQuietBelowItsLevel) {
  configure({.file = file_, .level = Level::warn, .console = false});
  debug("no");
  info("no");
  warn("yes");
  error("yes");
  EXPECT_EQ(lines().size(), 2u);
}

TEST_F(Log, ReplacesBytesThatAreNotUtf8) {
  configure({.file = file_, .console = false});
  info("a\xff\xc3\xa9 \xed\xa0\x80\x01");
  const auto all = lines();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_NE(all[0].find("a\\ufffd\xc3\xa9 \\ufffd\\ufffd\\ufffd\\u0001\""), std::string::npos) << all[0];
}

TEST_F(Log, LinesOfSeveralThreadsStayWhole) {
  configure({.file = file_, .console = false});
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([] {
      for (int i = 0; i < 100; ++i) info("line", {{"i", std::to_string(i)}});
    });
  for (auto& t : threads) t.join();
  const auto all = lines();
  ASSERT_EQ(all.size(), 400u);
  for (const std::string& line : all) EXPECT_TRUE(line.starts_with("{\"time\"") && line.ends_with("\"}")) << line;
}

TEST_F(Log, SaysWhenTheFileCannotBeWritten) {
  try {
    configure({.file = "/proc/no/such/log.jsonl", .console = false});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::io);
    EXPECT_NE(std::string(e.what()).find("--log-file"), std::string::npos);
  }
}

}  // namespace
}  // namespace periplus::log
