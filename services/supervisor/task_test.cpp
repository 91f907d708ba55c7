#include "services/supervisor/task.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/core/error.h"

namespace periplus::supervisor {
namespace {

class TaskFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / "periplus_task_test";
    std::filesystem::create_directories(folder_ / "tasks");
    std::ofstream(folder_ / "robot.yaml") << "a: 1\n";
    std::ofstream(folder_ / "scene.yaml") << "a: 1\n";
  }
  Task parse(const std::string& extra) {
    return parse_task("schema: 1\nname: t\nrobot: robot.yaml\nscene: scene.yaml\n" + extra, "t.yaml", (folder_ / "tasks").string());
  }
  std::string object_ = "object: {id: o, box_center_m: [1, 2, 0.5], box_size_m: [0.5, 0.6, 0.7], box_yaw_rad: 0.3}\n";
  std::filesystem::path folder_;
};

TEST_F(TaskFile, FindsFilesInFoldersAboveAndReadsBackWhatItWrites) {
  const Task t = parse(object_ + "stop: {most_looks: 5}\nseed: 7\ndds: {default: fastdds, simulator: cyclonedds}\ninstances: {nbv_planner: 3}\n");
  EXPECT_EQ(t.robot, std::filesystem::weakly_canonical(folder_ / "robot.yaml").string());
  EXPECT_EQ(t.stop.most_looks, 5);
  EXPECT_EQ(t.vendor("simulator"), "cyclonedds");
  EXPECT_EQ(t.vendor("walk_planner"), "fastdds");
  EXPECT_EQ(t.instances_of("nbv_planner"), 3);
  EXPECT_EQ(t.instances_of("simulator"), 1);
  const Task u = parse_task(t.yaml(), "resolved", "/");
  EXPECT_EQ(u.yaml(), t.yaml());
  EXPECT_TRUE(u.box.X_WB.isApprox(t.box.X_WB, 1e-12));
}

TEST_F(TaskFile, PathsThatYamlWouldReadOtherwiseComeBackAsTheyWere) {
  Task t = parse(object_ + "voxel_m: 0.1\nseed: 18446744073709551615\n");
  for (const std::string path : {"/a folder #1/robot: new.yaml", "/it's \"quoted\"/a.yaml", " leading and trailing ", "- a", "{b}", "&c", "*d", "true", "null",
                                 "~", "12", "# e", "f:", "[g", "!h", "%i", "@j", "é/ü.yaml", "back\\slash", "tab\there"}) {
    t.robot = t.scene = t.output = path;
    const Task u = parse_task(t.yaml(), "resolved", std::nullopt);
    EXPECT_EQ(u.robot, path);
    EXPECT_EQ(u.scene, path);
    EXPECT_EQ(u.output, path);
    EXPECT_EQ(u.yaml(), t.yaml());
    EXPECT_EQ(u.seed, t.seed);
    EXPECT_EQ(u.voxel_m, t.voxel_m);
  }
}

TEST_F(TaskFile, WhatCannotBeAFilesNameIsRefused) {
  for (const std::string& path : {std::string(300, 'x'), "/" + std::string(5000, 'y')}) {
    try {
      parse_task("schema: 1\nname: t\nrobot: " + path + "\nscene: scene.yaml\n" + object_, "t.yaml", folder_.string());
      FAIL() << path;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(e.what()).find("there is no file"), std::string::npos);
    }
  }
}

TEST_F(TaskFile, WithoutAFolderPathsStayAsTheyAre) {
  const Task t = parse_task("schema: 1\nname: t\nrobot: far/robot.yaml\nscene: /nowhere/scene.yaml\n" + object_, "task", std::nullopt);
  EXPECT_EQ(t.robot, "far/robot.yaml");
  EXPECT_EQ(t.scene, "/nowhere/scene.yaml");
}

TEST_F(TaskFile, BadInputNamesTheKeyAndWhatToDo) {
  const auto message = [&](const std::string& extra) -> std::string {
    try {
      parse(extra);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::bad_input);
      return e.what();
    }
    return "accepted";
  };
  EXPECT_NE(message(object_ + "voxel_mm: 3\n").find("voxel_m"), std::string::npos);
  EXPECT_NE(message(object_ + "stop: {most_look: 3}\n").find("most_looks"), std::string::npos);
  EXPECT_NE(message("object: {id: o, box_center_m: [1, 2, .nan], box_size_m: [1, 1, 1]}\n").find("box_center_m"), std::string::npos);
  EXPECT_NE(message("object: {id: a/b, box_center_m: [1, 2, 0], box_size_m: [1, 1, 1]}\n").find("id"), std::string::npos);
  EXPECT_NE(message(object_ + "voxel_m: 0.001\n").find("512"), std::string::npos);
  EXPECT_NE(message(object_ + "dds: {simulator: opendds}\n").find("fastdds"), std::string::npos);
  EXPECT_NE(message(object_ + "instances: {model_server: 2}\n").find("model_server runs once"), std::string::npos);
  EXPECT_NE(message(object_ + "instances: {nbv_planner: 0}\n").find("nbv_planner"), std::string::npos);
  EXPECT_NE(message("seed: 1\n").find("id"), std::string::npos);
}

}  // namespace
}  // namespace periplus::supervisor
