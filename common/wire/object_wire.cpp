#include "common/wire/object_wire.h"

#include <string>

#include "common/core/error.h"
#include "common/wire/common_wire.h"

namespace periplus::wire {

std::string environment_revision(std::string_view scene_yaml, std::string_view robot_yaml, std::string_view robot_urdf) {
  return scene::hash_of_texts({scene_yaml, robot_yaml, robot_urdf});
}

std::string scene_revision(std::string_view scene_yaml) { return scene::hash_of_texts({scene_yaml}); }

std::string robot_revision(std::string_view robot_yaml, std::string_view robot_urdf) { return scene::hash_of_texts({robot_yaml, robot_urdf}); }

msg::Environment environment_to_wire(std::string_view scene_id, std::string_view scene_yaml, std::string_view robot_yaml,
                                     std::string_view robot_urdf) {
  check_id(scene_id, "the scene's id");
  require(scene_yaml.size() <= 1048576 && robot_yaml.size() <= 1048576 && robot_urdf.size() <= 4194304, ErrorCode::bad_size,
          "an environment takes at most 1 MiB of scene, 1 MiB of robot YAML and 4 MiB of URDF");
  msg::Environment m;
  m.scene_id(std::string(scene_id));
  m.revision(environment_revision(scene_yaml, robot_yaml, robot_urdf));
  m.scene_yaml(text_to_wire(scene_yaml));
  m.robot_yaml(text_to_wire(robot_yaml));
  m.robot_urdf(text_to_wire(robot_urdf));
  return m;
}

msg::Environment environment_to_wire(const scene::EnvironmentTexts& t) {
  return environment_to_wire(t.scene_id, t.scene_yaml, t.robot_yaml, t.robot_urdf);
}

scene::EnvironmentTexts texts_from_wire(const msg::Environment& m) {
  return {id_from_wire(m.scene_id(), "the scene's id"), text_from_wire(m.scene_yaml()), text_from_wire(m.robot_yaml()), text_from_wire(m.robot_urdf())};
}

KnownEnvironment environment_from_wire(const msg::Environment& m) {
  KnownEnvironment e;
  const scene::EnvironmentTexts texts = texts_from_wire(m);
  require(!texts.scene_yaml.empty() && !texts.robot_yaml.empty() && !texts.robot_urdf.empty(), ErrorCode::bad_input,
          "an environment needs the scene's YAML, the robot's YAML and its URDF; one of them is empty");
  e.scene_id = texts.scene_id;
  e.revision = environment_revision(texts.scene_yaml, texts.robot_yaml, texts.robot_urdf);
  const std::string claimed = m.revision().to_string();
  require(claimed.empty() || claimed == e.revision, ErrorCode::bad_input,
          "the environment's revision is not the SHA-256 of its texts; leave it empty or compute it again");
  e.scene = scene::parse_scene(texts.scene_yaml, e.scene_id);
  e.collision = std::make_shared<const scene::CollisionWorld>(e.scene);
  e.robot = robot::RobotModel::load(texts.robot_urdf, texts.robot_yaml);
  return e;
}

msg::GridCounts to_wire(const voxel::Counts& counts) {
  msg::GridCounts m;
  m.unknown(counts.unknown);
  m.known(counts.known);
  m.empty(counts.empty);
  m.environment(counts.environment);
  return m;
}

voxel::Counts from_wire(const msg::GridCounts& m) { return {m.unknown(), m.known(), m.empty(), m.environment()}; }

}  // namespace periplus::wire
