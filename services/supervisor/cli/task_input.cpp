#include "services/supervisor/cli/task_input.h"

#include <fmt/format.h>

#include <ctime>

#include "common/core/config.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/mesh/made_models.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "common/core/locate.h"

namespace periplus::supervisor::cli {
namespace fs = std::filesystem;
namespace {

// The file itself, or a task of that name in the shared folders.
fs::path find_task(const std::string& file) {
  if (fs::is_regular_file(file)) return file;
  if (file.find('/') == std::string::npos)
    for (const fs::path& folder : share_folders())
      for (const std::string& name : {file, file + ".yaml"})
        if (fs::is_regular_file(folder / "tasks" / name)) return folder / "tasks" / name;
  throw Error(ErrorCode::io, "there is no task file " + file + "; give a path such as deploy/tasks/bunny.yaml");
}

}  // namespace

Task read_task(const std::string& file, const std::vector<std::string>& overrides, const std::string& output) {
  const fs::path path = find_task(file);
  config::Node node = config::load_file(path);
  for (const std::string& text : overrides) {
    const std::size_t equals = text.find('=');
    require(equals != std::string::npos && equals > 0, ErrorCode::bad_input, "--set " + text + ": write --set stop.most_looks=6");
    config::set(node, text.substr(0, equals), text.substr(equals + 1));
  }
  Task task = supervisor::read_task(node, fs::absolute(path).parent_path().string());
  if (!output.empty()) task.output = output;
  task.output = fs::absolute(task.output).lexically_normal().string();
  return task;
}

EnvironmentTexts read_environment(const Task& task) {
  EnvironmentTexts texts;
  const std::string scene_text = read_file(task.scene);
  const scene::Scene scene = scene::parse_scene(scene_text, task.scene);
  texts.scene_id = scene.name;
  texts.scene_yaml = scene::without_truth(scene_text);
  texts.robot_yaml = read_file(task.robot);
  texts.robot_urdf = read_file(fs::path(task.robot).replace_extension(".urdf"));
  try {
    robot::RobotModel::load(texts.robot_urdf, texts.robot_yaml);
  } catch (const Error& e) {
    throw Error(e.code(), task.robot + ": " + e.what());
  }
  return texts;
}

void check_true_object(const Task& task) {
  const scene::Scene scene = scene::load_scene(task.scene);
  if (!scene.truth) return;
  std::string path;
  mesh::load_named(scene.truth->mesh, {fs::path(task.scene).parent_path().string()}, path);
}

std::string run_id_of(const std::string& task_name, std::chrono::system_clock::time_point now) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  std::tm t{};
  gmtime_r(&seconds, &t);
  return fmt::format("{:04}{:02}{:02}-{:02}{:02}{:02}-{}", t.tm_year + 1900, t.tm_mon + 1, t.tm_mday, t.tm_hour, t.tm_min, t.tm_sec, task_name);
}

}  // namespace periplus::supervisor::cli
