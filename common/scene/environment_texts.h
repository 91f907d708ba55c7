// What a robot may know of its world and of itself, as the texts of the files: the scene without `truth`, its own YAML and URDF.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

namespace periplus::scene {

struct EnvironmentTexts {
  std::string scene_id, scene_yaml, robot_yaml, robot_urdf;
  bool operator==(const EnvironmentTexts&) const = default;
};

// SHA-256 of texts with their lengths: revisions of what is made of texts.
std::string hash_of_texts(std::initializer_list<std::string_view> texts);
// The revision of an environment: what models are begun in and postures are planned in.
std::string environment_revision(const EnvironmentTexts& texts);

}  // namespace periplus::scene
