#include "services/supervisor/run_report.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"

namespace periplus::supervisor {
namespace {

TEST(RunReport, OneFileWithoutLinksThatTellsTheRun) {
  const std::string folder = testing::TempDir() + "/run_report_test";
  std::filesystem::create_directories(folder);
  const nlohmann::json X = {{0, 0, 1, -1.2}, {-1, 0, 0, 0.1}, {0, -1, 0, 1.2}, {0, 0, 0, 1}};
  nlohmann::json look = {{"look", 1}, {"pose_world_camera", X}, {"predicted_gain_px", nullptr}, {"found_gain_px", 1200.0},
                         {"voxels", {{"unknown", 5000}, {"known", 700}}}, {"seconds", {{"walk", 3.25}, {"vision.sgbm", 0.2}}}, {"coverage", 0.41}};
  const nlohmann::json report = {{"task", "<bunny>"}, {"looks", {look}}, {"exit", {{"status", 3}, {"state", "spent"}, {"reason", "looks taken"}}},
                                 {"forbidden_poses", {X}}, {"coverage_reachable", 0.41}, {"vendors", {{"simulator", "cyclonedds"}}},
                                 {"walks", {{{"path", {{0, 0, 0}, {1, 1, 0}}}, {"steps", {{0, 0.5, 0.5, 0}}}}}}};
  std::ofstream(folder + "/report.json") << report.dump();
  std::ofstream(folder + "/scene.yaml") << "schema: periplus-scene-1\nname: empty\nroom: {size_m: [6, 6, 2.8]}\n";
  const std::string html = html_report(folder);
  EXPECT_EQ(html.find("http"), std::string::npos);   // opens offline
  EXPECT_NE(html.find("&lt;bunny&gt;"), std::string::npos);
  EXPECT_NE(html.find("41.0 %"), std::string::npos);
  EXPECT_NE(html.find("looks taken"), std::string::npos);
  EXPECT_NE(html.find("simulator: cyclonedds"), std::string::npos);
  EXPECT_NE(html.find("3.25"), std::string::npos);
  EXPECT_NE(html.find("class=forbidden"), std::string::npos);
}

TEST(RunReport, SaysWhichFileIsMissingOrDamaged) {
  EXPECT_THROW(html_report("/no/such/run"), Error);
  const std::string folder = testing::TempDir() + "/run_report_damaged";
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/report.json") << "{\"looks\": [{}]";
  EXPECT_THROW(html_report(folder), Error);
}

}  // namespace
}  // namespace periplus::supervisor
