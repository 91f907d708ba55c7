// An environment that parses: a small scene and the robot of deploy/robots.
#pragma once

#include <fstream>
#include <sstream>
#include <string>

namespace periplus::wire::testing {

struct Texts {
  std::string scene_yaml, robot_yaml, robot_urdf;
};

inline std::string file_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

inline Texts environment_texts() {
  const std::string robots = PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like";
  return {"schema: periplus-scene-1\n"
          "name: room\n"
          "room: {size_m: [5, 4, 2.5]}\n"
          "solids:\n"
          "  - {name: table, size_m: [0.7, 0.7, 0.7], position_m: [0, 0, 0.35], supports_object: true}\n"
          "robot_start: {x_m: -1.5, y_m: 0, yaw_deg: 0}\n",
          file_text(robots + ".yaml"), file_text(robots + ".urdf")};
}

}  // namespace periplus::wire::testing
