#include "services/supervisor/cli/task_input.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>

#include "common/core/error.h"

namespace periplus::supervisor::cli {
namespace {

const std::string kTaskText = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/tasks/bunny.yaml";

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing was thrown";
}

TEST(TaskInput, OverridesGoIntoTheTask) {
  const Task plain = read_task(kTaskText, {}, "");
  const Task task = read_task(kTaskText, {"stop.most_looks=6", "voxel_m=0.02", "dds.simulator=cyclonedds"}, "elsewhere");
  EXPECT_NE(plain.stop.most_looks, 6);
  EXPECT_EQ(task.stop.most_looks, 6);
  EXPECT_EQ(task.voxel_m, 0.02);
  EXPECT_EQ(task.vendor("simulator"), "cyclonedds");
  EXPECT_EQ(task.output, (std::filesystem::current_path() / "elsewhere").string());
  EXPECT_EQ(task.scene, plain.scene);
}

TEST(TaskInput, ABareNameIsATaskThatCameAlong) { EXPECT_EQ(read_task("bunny", {}, "").name, "bunny"); }

TEST(TaskInput, SaysWhatIsWrong) {
  EXPECT_NE(message_of([] { read_task("no-such-task", {}, ""); }).find("there is no task file no-such-task"), std::string::npos);
  EXPECT_NE(message_of([] { read_task(kTaskText, {"voxel_m"}, ""); }).find("write --set"), std::string::npos);
  EXPECT_NE(message_of([] { read_task(kTaskText, {"stop.most_lokos=3"}, ""); }).find("most_looks"), std::string::npos);
}

TEST(TaskInput, ErrorsNameTheLineOfTheFile) {
  const std::string file = testing::TempDir() + "/periplus_task_" + std::to_string(::getpid()) + ".yaml";
  std::ofstream(file) << "# a comment\n\nschema: 1\nname: x\nrobto: y\n";
  EXPECT_NE(message_of([&] { read_task(file, {"schema=2"}, ""); }).find("schema must be 1"), std::string::npos);
  std::ofstream(file) << "# a comment\n\nschema: 1\nname: [x]\n";
  EXPECT_EQ(message_of([&] { read_task(file, {}, ""); }), file + ":4: name: expected a text");
  std::filesystem::remove(file);
}

TEST(TaskInput, TheEnvironmentHoldsNoTruth) {
  const EnvironmentTexts texts = read_environment(read_task(kTaskText, {}, ""));
  EXPECT_FALSE(texts.scene_yaml.empty());
  EXPECT_EQ(texts.scene_yaml.find("truth"), std::string::npos);
  EXPECT_NE(texts.robot_urdf.find("<robot"), std::string::npos);
}

TEST(TaskInput, ABrokenRobotIsRefusedWithItsFile) {
  const auto folder = std::filesystem::temp_directory_path() / ("periplus_task_input_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  Task task = read_task(kTaskText, {}, "");
  std::filesystem::copy(task.robot, folder / "robot.yaml");
  task.robot = folder / "robot.yaml";
  EXPECT_NE(message_of([&] { read_environment(task); }).find("robot.urdf"), std::string::npos);
  std::ofstream(folder / "robot.urdf") << "<robot name='r'><link name='base'/></robot>";
  EXPECT_NE(message_of([&] { read_environment(task); }).find("robot.yaml"), std::string::npos);
  std::filesystem::remove_all(folder);
}

TEST(TaskInput, TheTrueObjectsMeshMustBeThereAndWhole) {
  const auto folder = std::filesystem::temp_directory_path() / ("periplus_true_object_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const auto write_scene = [&](const std::string& truth) {
    std::ofstream(folder / "scene.yaml") << "schema: periplus-scene-1\nname: s\nroom: {size_m: [4, 4, 2.5]}\n"
                                         << truth;
  };
  Task task = read_task(kTaskText, {}, "");
  task.scene = folder / "scene.yaml";
  write_scene("");
  EXPECT_NO_THROW(check_true_object(task)) << "no truth, nothing to be loaded";
  write_scene("truth: {mesh: object.obj, longest_side_m: 0.4, position_m: [0, 0, 0]}\n");
  EXPECT_NE(message_of([&] { check_true_object(task); }).find(folder.string()), std::string::npos) << "names the folders";
  EXPECT_NO_THROW(read_environment(task)) << "a client needs no mesh where the simulator runs elsewhere";
  std::ofstream(folder / "object.obj") << "this is no mesh";
  EXPECT_NE(message_of([&] { check_true_object(task); }).find("object.obj"), std::string::npos);
  std::ofstream(folder / "object.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  EXPECT_NO_THROW(check_true_object(task));
  std::filesystem::remove_all(folder);
}

TEST(TaskInput, RunsAreNamedByTimeAndTask) {
  EXPECT_EQ(run_id_of("bunny", std::chrono::system_clock::from_time_t(0)), "19700101-000000-bunny");
}

}  // namespace
}  // namespace periplus::supervisor::cli
