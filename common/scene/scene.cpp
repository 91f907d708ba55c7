#include "common/scene/scene.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <set>
#include <sstream>

#include "common/core/config.h"
#include "common/core/error.h"
#include "common/scene/mesh_solid.h"

namespace periplus::scene {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::size_t kMostSolids = 256;
constexpr std::size_t kMostTriangles = 100000;  // of all meshes: a tenth of a second for whoever evaluates a view
constexpr std::size_t kMostLights = 7;  // OpenGL's fixed pipeline has eight, one of them is the head light
constexpr std::size_t kMostLandmarks = 256;
constexpr std::size_t kLongestText = 4u << 20;

[[noreturn]] void refuse(const config::Node& node, const std::string& sentence) {
  throw_error(ErrorCode::bad_input, node.where() + ": " + sentence);
}

void check_bounds(const config::Node& node, const char* key, const Eigen::Vector3d& v, double low, double high) {
  if (!v.allFinite() || v.minCoeff() < low || v.maxCoeff() > high) {
    std::ostringstream s;
    s << key << ": three numbers from " << low << " to " << high << " are expected";
    refuse(node, s.str());
  }
}

std::string read_name(const config::Node& node, std::set<std::string>& taken) {
  const auto name = node.get<std::string>("name");
  const bool plain = name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-") == std::string::npos;
  if (name.empty() || name.size() > 64 || !plain) refuse(node, "name: 1 to 64 letters, digits, '_', '.' or '-' are expected");
  if (!taken.insert(name).second) refuse(node, "name: \"" + name + "\" is already taken; names must differ");
  return name;
}

// A file name stays below the assets folders.
void read_texture(const config::Node& node, const char* key, std::string& texture) {
  node.read(key, texture);
  if (texture.size() > 512 || texture.starts_with('/') || texture.find("..") != std::string::npos)
    refuse(node, std::string(key) + ": a file name below the assets folders, \"noise:<seed>\" or \"materials:<seed>\" is expected");
  for (const std::string kind : {"noise:", "materials:"})
    if (texture.starts_with(kind)) {
      const std::string seed = texture.substr(kind.size());
      if (seed.empty() || seed.size() > 9 || seed.find_first_not_of("0123456789") != std::string::npos)
        refuse(node, std::string(key) + ": \"" + kind + "<seed>\" needs a seed of 1 to 9 digits");
    }
}

Pose read_pose(const config::Node& node) {
  const auto p = node.get<Eigen::Vector3d>("position_m");
  check_bounds(node, "position_m", p, -100, 100);
  double yaw = 0, pitch = 0, roll = 0;
  node.read("yaw_deg", yaw, {-360, 360});
  node.read("pitch_deg", pitch, {-360, 360});
  node.read("roll_deg", roll, {-360, 360});
  return make_pose(p, rotation_from_yaw_pitch_roll(yaw * kDegree, pitch * kDegree, roll * kDegree));
}

std::shared_ptr<const MeshSolid> read_mesh(const config::Node& node) {
  const auto name = node.get<std::string>("mesh");
  if (name.empty() || name.size() > 512 || name.starts_with('/') || name.find("..") != std::string::npos)
    refuse(node, "mesh: a file name below the assets folders, or one made by us (\"made:ship\"), is expected");
  double longest_side = 0;
  if (!node.read("longest_side_m", longest_side, {0.001, 100})) refuse(node, "longest_side_m: a mesh needs the length of its longest side");
  std::string up_axis = "z";
  node.read_choice("up_axis", up_axis, {"x", "y", "z", "-x", "-y", "-z"});
  try {
    return MeshSolid::load(name, longest_side, up_axis);
  } catch (const Error& e) {
    refuse(node, std::string("mesh: ") + e.what());
  }
}

Solid read_solid(const config::Node& node, std::set<std::string>& names) {
  Solid s;
  s.name = read_name(node, names);
  std::string shape = "box";
  node.read_choice("shape", shape, {"box", "cylinder", "sphere", "mesh"});
  if (shape == "box") {
    s.size = node.get<Eigen::Vector3d>("size_m");
  } else if (shape == "mesh") {
    s.shape = Shape::mesh;
    s.mesh = read_mesh(node);
    s.size = s.mesh->size();
  } else {
    const auto diameter = node.get<double>("diameter_m");
    s.shape = shape == "cylinder" ? Shape::cylinder : Shape::sphere;
    s.size = {diameter, diameter, s.shape == Shape::cylinder ? node.get<double>("height_m") : diameter};
  }
  check_bounds(node, "size", s.size, s.shape == Shape::mesh ? 0 : 0.001, 100);
  s.X_WS = read_pose(node);
  read_texture(node, "texture", s.texture);
  node.read("rgb", s.rgb);
  check_bounds(node, "rgb", s.rgb, 0, 1);
  node.read("supports_object", s.supports_object);
  return s;
}

Landmark read_landmark(const config::Node& node, std::set<std::string>& names) {
  Landmark l;
  l.name = read_name(node, names);
  l.position = node.get<Eigen::Vector3d>("position_m");
  check_bounds(node, "position_m", l.position, -100, 100);
  l.normal = node.get<Eigen::Vector3d>("normal");
  if (!(l.normal.norm() > 1e-6)) refuse(node, "normal: a direction is expected, not a zero vector");
  l.normal.normalize();
  node.read("size_m", l.size, {0.001, 10});
  return l;
}

CameraImperfections read_cameras(const config::Node& node) {
  CameraImperfections c;
  const auto number = [&node](const char* key, std::optional<double>& value, config::Range range) {
    double read = 0;
    if (node.read(key, read, range)) value = read;
  };
  number("noise_grey", c.noise, {0, 100});
  number("right_gain", c.right_gain, {0.1, 10});
  number("right_offset_grey", c.right_offset, {-255, 255});
  const auto distortion = [&node](const char* key, std::vector<double>& values) {
    if (node.read(key, values) && !values.empty() && values.size() != 5)
      refuse(node, std::string(key) + ": five coefficients k1, k2, p1, p2, k3 are expected, or [] for none");
  };
  distortion("left_distortion", c.left_distortion);
  distortion("right_distortion", c.right_distortion);
  distortion("wide_distortion", c.wide_distortion);
  return c;
}

Truth read_truth(const config::Node& node) {
  Truth t;
  t.mesh = node.get<std::string>("mesh");
  if (t.mesh.empty() || t.mesh.size() > 1000) refuse(node, "mesh: the name of a mesh file is expected");
  node.read("longest_side_m", t.longest_side, {0.01, 5});
  node.read_choice("up_axis", t.up_axis, {"x", "y", "z", "-x", "-y", "-z"});
  t.X_WO = read_pose(node);
  read_texture(node, "texture", t.texture);
  return t;
}

bool begins_key(std::string_view line, std::string_view key) {
  for (const std::string_view quote : {"", "\"", "'"}) {
    const std::string head = std::string(quote) + std::string(key) + std::string(quote);
    if (!line.starts_with(head)) continue;
    const std::size_t colon = line.find_first_not_of(" \t", head.size());
    if (colon != std::string_view::npos && line[colon] == ':') return true;
  }
  return false;
}

}  // namespace

Scene parse_scene(std::string_view yaml, std::string_view name) {
  require(yaml.size() <= kLongestText, ErrorCode::bad_size, std::string(name) + ": a scene may have at most 4 MiB of text");
  const config::Node root = config::parse(yaml, name);
  std::string schema = "periplus-scene-1";
  root.read_choice("schema", schema, {"periplus-scene-1"});
  Scene scene;
  scene.name = root.get<std::string>("name");
  if (scene.name.empty() || scene.name.size() > 64) refuse(root, "name: 1 to 64 characters are expected");

  const config::Node room = root.child("room");
  room.read("size_m", scene.room.size);
  check_bounds(room, "size_m", scene.room.size, 0.5, 100);
  read_texture(room, "wall_texture", scene.room.wall_texture);
  read_texture(room, "floor_texture", scene.room.floor_texture);

  std::set<std::string> names;
  const auto solids = root.children("solids");
  if (solids.size() > kMostSolids) refuse(root, "solids: at most 256 are possible");
  std::size_t triangles = 0;
  for (const config::Node& node : solids) {
    scene.solids.push_back(read_solid(node, names));
    if (const auto& mesh = scene.solids.back().mesh) triangles += mesh->mesh().triangles.size();
    if (triangles > kMostTriangles) refuse(node, "mesh: the meshes among the solids have more than 100000 triangles together; simplify them");
  }

  const auto lights = root.children("lights");
  if (lights.size() > kMostLights) refuse(root, "lights: at most 7 are possible");
  for (const config::Node& node : lights) {
    Light light;
    node.read("position_m", light.position);
    check_bounds(node, "position_m", light.position, -100, 100);
    node.read("intensity", light.intensity, {0, 1});
    scene.lights.push_back(light);
  }

  const auto landmarks = root.children("landmarks");
  if (landmarks.size() > kMostLandmarks) refuse(root, "landmarks: at most 256 are possible");
  for (const config::Node& node : landmarks) scene.landmarks.push_back(read_landmark(node, names));

  scene.cameras = read_cameras(root.child("cameras"));

  const config::Node start = root.child("robot_start");
  start.read("x_m", scene.robot_start.x, {-100, 100});
  start.read("y_m", scene.robot_start.y, {-100, 100});
  double yaw_deg = 0;
  start.read("yaw_deg", yaw_deg, {-360, 360});
  scene.robot_start.yaw = wrap_angle(yaw_deg * kDegree);
  if (std::abs(scene.robot_start.x) > scene.room.size.x() / 2 || std::abs(scene.robot_start.y) > scene.room.size.y() / 2)
    refuse(start, "the robot's start lies outside the room");

  if (root.has("truth")) scene.truth = read_truth(root.child("truth"));
  root.finish();
  return scene;
}

Scene load_scene(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  require(file.good(), ErrorCode::io, path + ": the scene file cannot be read; check its path");
  std::string text(kLongestText + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return parse_scene(text, path);
}

std::string without_truth(std::string_view yaml) {
  std::string kept;
  bool inside = false;
  while (!yaml.empty()) {
    const std::size_t end = yaml.find('\n');
    const std::string_view line = yaml.substr(0, end == std::string_view::npos ? yaml.size() : end + 1);
    yaml.remove_prefix(line.size());
    const bool top_level = line.find_first_of(" \t#\r\n") != 0;
    if (top_level) inside = begins_key(line, "truth");
    if (!inside) kept += line;
  }
  // Other spellings of the key (a flow mapping, an explicit "? truth") would get through the lines above.
  require(!config::parse(kept, "scene").has("truth"), ErrorCode::bad_input,
          "scene: write `truth:` as a key of its own at the beginning of a line, so that it can be kept from the robot");
  return kept;
}

}  // namespace periplus::scene
