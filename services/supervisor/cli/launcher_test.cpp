#include "services/supervisor/cli/launcher.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "common/core/error.h"
#include "services/supervisor/cli/process.h"

namespace periplus::supervisor::cli {
namespace {

using namespace std::chrono_literals;
using Kind = Launcher::Event::Kind;

class LauncherTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("periplus_launcher_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Program program(const std::string& service, const std::string& script, bool may_restart) {
    const auto path = folder_ / program_name(service);
    std::ofstream(path) << "#!/bin/sh\n" << script << "\n";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return {.service = service, .name = service, .path = path, .arguments = {}, .environment = {{"WHO", service}}, .restarts = may_restart};
  }
  // Events until `count` of them came, or 5 s.
  static std::vector<Launcher::Event> events(Launcher& launcher, std::size_t count) {
    std::vector<Launcher::Event> all;
    for (int i = 0; i < 500 && all.size() < count; ++i) {
      for (auto& e : launcher.supervise()) all.push_back(e);
      std::this_thread::sleep_for(10ms);
    }
    return all;
  }
  int lines(const std::string& file) {
    std::ifstream in(folder_ / "logs" / file);
    int n = 0;
    for (std::string line; std::getline(in, line);) ++n;
    return n;
  }
  std::filesystem::path folder_;
};

TEST_F(LauncherTest, RestartsThreeTimesThenGivesUp) {
  Launcher launcher({program("walk_planner", "echo $WHO; exit 1", true)}, folder_ / "logs");
  launcher.start();
  const auto all = events(launcher, 4);
  ASSERT_EQ(all.size(), 4u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(all[static_cast<std::size_t>(i)].kind, Kind::restarted);
  EXPECT_EQ(all[3].kind, Kind::lost);
  EXPECT_NE(all[3].text.find("ended with status 1 after 3 restarts"), std::string::npos) << all[3].text;
  EXPECT_EQ(lines("walk_planner.out"), 4);
  EXPECT_TRUE(launcher.supervise().empty());
}

TEST_F(LauncherTest, AKilledProgramWithStateIsLostAtOnce) {
  Launcher launcher({program("simulator", "exec sleep 100", false), program("nbv_planner", "exec sleep 100", true)}, folder_ / "logs");
  launcher.start();
  EXPECT_TRUE(launcher.supervise().empty());
  const auto before = launcher.pids();
  ASSERT_EQ(before.size(), 2u);
  ::kill(before.at("simulator"), SIGKILL);
  ::kill(before.at("nbv_planner"), SIGKILL);
  const auto all = events(launcher, 2);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].service, "simulator");
  EXPECT_EQ(all[0].kind, Kind::lost);
  EXPECT_NE(all[0].text.find("signal 9"), std::string::npos);
  EXPECT_EQ(all[1].kind, Kind::restarted);
  EXPECT_NE(launcher.pids().at("nbv_planner"), before.at("nbv_planner"));
}

TEST_F(LauncherTest, OneOfSeveralInstancesMayGo) {
  Program second = program("nbv_planner", "[ $WHO = other ] && exit 1; exec sleep 100", true);
  second.name = "nbv_planner-2";
  second.environment["WHO"] = "other";
  Launcher launcher({program("nbv_planner", "[ $WHO = other ] && exit 1; exec sleep 100", true), second}, folder_ / "logs");
  launcher.start();
  const auto all = events(launcher, 4);
  ASSERT_EQ(all.size(), 4u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(all[i].kind, Kind::restarted);
  EXPECT_EQ(all[3].kind, Kind::fewer);
  EXPECT_EQ(all[3].text.rfind("nbv_planner-2 ended", 0), 0u) << all[3].text;
  const auto pids = launcher.pids();
  ASSERT_EQ(pids.size(), 1u);
  ::kill(pids.at("nbv_planner"), SIGKILL);
  EXPECT_EQ(events(launcher, 1).at(0).kind, Kind::restarted);
}

TEST_F(LauncherTest, ARefusedConfigurationIsNotTriedAgain) {
  Launcher launcher({program("walk_planner", "echo 'walk_planner: steps.width_m must be positive'; exit 2", true)}, folder_ / "logs");
  launcher.start();
  const auto all = events(launcher, 1);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].kind, Kind::lost);
  EXPECT_TRUE(all[0].refused);
  EXPECT_EQ(all[0].text, "walk_planner refused to start: walk_planner: steps.width_m must be positive");
}

TEST_F(LauncherTest, StopAsksThenKills) {
  Launcher launcher({program("vision_server", "trap 'echo bye; exit 0' TERM; echo up; while :; do sleep 0.02; done", true),
                     program("model_server", "trap '' TERM; echo up; while :; do sleep 0.02; done", true)},
                    folder_ / "logs");
  launcher.start();
  for (int i = 0; i < 500 && (lines("vision_server.out") < 1 || lines("model_server.out") < 1); ++i) std::this_thread::sleep_for(10ms);
  const auto pids = launcher.pids();
  launcher.stop(500ms);
  EXPECT_EQ(lines("vision_server.out"), 2);
  for (const auto& [service, pid] : pids) EXPECT_FALSE(start_ticks(pid)) << service;
  EXPECT_TRUE(launcher.pids().empty());
  launcher.stop();
}

TEST_F(LauncherTest, AMissingProgramStopsTheOthers) {
  Program missing = program("walk_planner", "", true);
  std::filesystem::remove(missing.path);
  Launcher launcher({program("vision_server", "exec sleep 100", true), missing}, folder_ / "logs");
  try {
    launcher.start();
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("periplus-walk-planner"), std::string::npos) << e.what();
  }
  EXPECT_TRUE(launcher.pids().empty());
}

TEST(Programs, FollowTheTask) {
  Task task;
  task.scene = "/a/scene.yaml";
  task.robot = "/a/robot.yaml";
  task.truth = true;
  task.dds = {{"default", "fastdds"}, {"simulator", "cyclonedds"}};
  const auto programs = programs_of(task, "/bin/here", "/run/logs");
  ASSERT_EQ(programs.size(), 8u);
  EXPECT_EQ(programs[0].path, "/bin/here/periplus-simulator");
  EXPECT_EQ(programs[0].arguments,
            (std::vector<std::string>{"--log-file", "/run/logs/simulator.jsonl", "--scene", "/a/scene.yaml", "--robot", "/a/robot.yaml", "--truth"}));
  EXPECT_EQ(programs[0].environment.at("PERIPLUS_DDS"), "cyclonedds");
  EXPECT_EQ(programs[2].arguments.back(), "store_folder=\"/run/knowledge\"");
  EXPECT_EQ(programs[1].environment.at("PERIPLUS_DDS"), "fastdds");
  EXPECT_FALSE(programs[0].restarts);
  EXPECT_TRUE(programs[1].restarts);
  task.instances = {{"nbv_planner", 2}};
  const auto more = programs_of(task, "/bin/here", "/run/logs");
  ASSERT_EQ(more.size(), 9u);
  const auto second = std::find_if(more.begin(), more.end(), [](const Program& p) { return p.name == "nbv_planner-2"; });
  ASSERT_NE(second, more.end());
  EXPECT_EQ(second->service, "nbv_planner");
  EXPECT_EQ(second->path, "/bin/here/periplus-nbv-planner");
  EXPECT_EQ(second->arguments, (std::vector<std::string>{"--log-file", "/run/logs/nbv_planner-2.jsonl"}));
  task.truth = false;
  EXPECT_NE(programs_of(task, "/bin/here", "/logs")[0].arguments.back(), "--truth");
}

}  // namespace
}  // namespace periplus::supervisor::cli
