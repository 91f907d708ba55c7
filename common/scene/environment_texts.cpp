#include "common/scene/environment_texts.h"

#include "common/core/hash.h"

namespace periplus::scene {

std::string hash_of_texts(std::initializer_list<std::string_view> texts) {
  Sha256 hash;
  for (const std::string_view text : texts) {
    hash.update(std::to_string(text.size()) + "\n");
    hash.update(text);
  }
  return hash.hex();
}

std::string environment_revision(const EnvironmentTexts& texts) { return hash_of_texts({texts.scene_yaml, texts.robot_yaml, texts.robot_urdf}); }

}  // namespace periplus::scene
