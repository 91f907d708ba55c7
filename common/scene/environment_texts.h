// What a robot may know of its world and of itself, as the texts of the files: the scene without `truth`, its own YAML and URDF.
#pragma once

#include <string>

namespace periplus::scene {

struct EnvironmentTexts {
  std::string scene_id, scene_yaml, robot_yaml, robot_urdf;
  bool operator==(const EnvironmentTexts&) const = default;
};

}  // namespace periplus::scene
