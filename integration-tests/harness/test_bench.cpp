#include "integration-tests/harness/test_bench.h"

#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "common/core/error.h"
#include "common/core/file.h"

namespace periplus::harness {

const char* BallOnTable::scene_yaml() {
  return R"(schema: periplus-scene-1
name: ball-on-table
room: {size_m: [6.0, 6.0, 2.8]}
solids:
  - {name: table, shape: box, size_m: [0.7, 0.7, 0.7], position_m: [0, 0, 0.35], supports_object: true}
robot_start: {x_m: -1.5, y_m: 0.0, yaw_deg: 0}
)";
}

Eigen::Vector3d BallOnTable::center() { return {0, 0, 0.7 + kRadius}; }

object_model::ObjectBox BallOnTable::box() {
  object_model::ObjectBox box;
  box.size = {0.4, 0.4, 0.36};
  box.X_WB.translation() = Eigen::Vector3d(0, 0, 0.7 + 0.18);
  return box;
}

AnalyticScene BallOnTable::scene(bool plain) {
  scene::Solid ball;
  ball.shape = scene::Shape::sphere;
  ball.size.setConstant(2 * kRadius);
  ball.X_WS.translation() = center();
  AnalyticScene out(scene::parse_scene(scene_yaml(), "ball-on-table"), {ball});
  out.plain_object = plain;
  return out;
}

Pose BallOnTable::view(double azimuth, double height, double distance) {
  const double rise = height - center().z(), radius = std::sqrt(distance * distance - rise * rise);
  const Eigen::Vector3d middle(radius * std::cos(azimuth), radius * std::sin(azimuth), height);
  return look_at(middle, center()) * Eigen::Translation3d(-0.072, 0, 0);
}

TestBench::TestBench(const std::string& name) {
  folder_ = (std::filesystem::temp_directory_path() / ("periplus-" + name + "-" + std::to_string(::getpid()))).string();
  std::filesystem::remove_all(folder_);
  std::filesystem::create_directories(folder_);
  const std::filesystem::path robots = std::filesystem::path(PERIPLUS_SOURCE_DIR) / "deploy/robots";
  robot_yaml_ = read_file(robots / "hrp2like.yaml");
  robot_urdf_ = read_file(robots / "hrp2like.urdf");
  robot_ = robot::RobotModel::load(robot_urdf_, robot_yaml_);
  dds::NodeOptions options = dds::NodeOptions::from_environment("test-" + name);
  options.domain = domain_.id();
  node_ = dds::Node::create(options);
}

TestBench::~TestBench() {
  stop_all();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

Program& TestBench::start(const std::string& program, const std::vector<std::string>& arguments,
                          const Program::Environment& more) {
  Program::Environment environment{{"PERIPLUS_DOMAIN", std::to_string(domain_.id())}, {"XDG_STATE_HOME", folder_ + "/state"}};
  for (const auto& [key, value] : more) environment[key] = value;
  programs_.push_back(std::make_unique<Program>(std::string(PERIPLUS_BIN_DIR) + "/" + program, arguments, environment,
                                                folder_ + "/" + program + ".log"));
  return *programs_.back();
}

void TestBench::stop_all() { programs_.clear(); }

std::string TestBench::logs() const {
  std::string text;
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    if (entry.path().extension() == ".log") text += entry.path().filename().string() + ":\n" + read_file(entry.path());
  return text;
}

}  // namespace periplus::harness
