#include "services/supervisor/task.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "common/core/config.h"
#include "common/core/error.h"
#include "common/service/service_names.h"

namespace periplus::supervisor {

namespace fs = std::filesystem;

namespace {

bool has_vendor(const std::string& key) {
  const auto& names = service::service_names();
  return key == "default" || std::find(names.begin(), names.end(), key) != names.end();
}

// Any instance of these answers any request.
constexpr std::array kStateless{"nbv_planner", "posture_generator", "walk_planner"};
constexpr int kMostOfAService = 8;

bool is_name(const std::string& text, std::size_t longest) {
  if (text.empty() || text.size() > longest || text[0] == '.') return false;
  for (const char c : text)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-')) return false;
  return true;
}

// What cannot be a file's name, or may not be looked at, is no file.
bool names_a_file(const fs::path& path) {
  std::error_code problem;
  return fs::is_regular_file(path, problem);
}

std::string resolve(const std::string& path, const std::optional<std::string>& whence, const std::string& where) {
  if (!whence) return path;
  const std::string& folder = *whence;
  if (fs::path(path).is_absolute()) {
    require(names_a_file(path), ErrorCode::bad_input, where + ": there is no file " + path);
    return path;
  }
  for (fs::path base = fs::absolute(folder);; base = base.parent_path()) {
    const fs::path candidate = base / path;
    if (names_a_file(candidate)) return fs::weakly_canonical(candidate).string();
    if (base == base.root_path()) break;
  }
  throw_error(ErrorCode::bad_input,
              where + ": there is no file " + path + " in " + folder + " or any folder above it; give a path that exists");
}

}  // namespace

std::string Task::vendor(const std::string& service) const {
  if (const auto it = dds.find(service); it != dds.end()) return it->second;
  if (const auto it = dds.find("default"); it != dds.end()) return it->second;
  return "";
}

int Task::instances_of(const std::string& service) const {
  const auto it = instances.find(service);
  return it == instances.end() ? 1 : it->second;
}

Task parse_task(std::string_view yaml, std::string_view name, const std::optional<std::string>& folder) { return read_task(config::parse(yaml, name), folder); }

Task read_task(const config::Node& root, const std::optional<std::string>& folder) {
  Task t;
  int schema = 0;
  root.read("schema", schema);
  require(schema == 1, ErrorCode::bad_input, root.where() + ": schema must be 1, the only one there is; write `schema: 1`");
  t.name = root.get<std::string>("name");
  require(is_name(t.name, 40), ErrorCode::bad_input, root.where() + ": name must be 1 to 40 of the characters A-Z a-z 0-9 _ . -");
  t.robot = resolve(root.get<std::string>("robot"), folder, root.where() + ": robot");
  t.scene = resolve(root.get<std::string>("scene"), folder, root.where() + ": scene");

  const config::Node object = root.child("object");
  t.object_id = object.get<std::string>("id");
  require(is_name(t.object_id, 64), ErrorCode::bad_input, object.where() + ": id must be 1 to 64 of the characters A-Z a-z 0-9 _ . -");
  const auto center = object.get<Eigen::Vector3d>("box_center_m");
  t.box.size = object.get<Eigen::Vector3d>("box_size_m");
  require((t.box.size.array() > 0).all() && (t.box.size.array() <= 20).all(), ErrorCode::bad_input,
          object.where() + ": box_size_m needs three lengths in (0, 20]");
  double yaw = 0;
  object.read("box_yaw_rad", yaw);
  t.box.X_WB = make_pose(center, rotation_from_yaw_pitch_roll(yaw, 0, 0));

  root.read("voxel_m", t.voxel_m, {.minimum = 0.001, .maximum = 1.0});
  require((t.box.size.array() / t.voxel_m <= 512).all(), ErrorCode::bad_input,
          root.where() + ": the box has more than 512 voxels along a side; make voxel_m larger or the box smaller");
  const config::Node stop = root.child("stop");
  stop.read("least_gain_voxels", t.stop.least_gain_voxels, {.minimum = 0});
  stop.read("discount_looks", t.stop.discount_looks, {.minimum = 0, .maximum = 20});
  stop.read("variation_voxels", t.stop.variation_voxels, {.minimum = 0});
  stop.read("most_looks", t.stop.most_looks, {.minimum = 1, .maximum = 99});
  stop.read("most_time_s", t.stop.most_time_s, {.minimum = 1, .maximum = 86400});
  root.read("seed", t.seed);
  root.read_choice("motion_mode", t.motion_mode, {"ideal"});
  root.read("truth", t.truth);
  root.read("most_forbidden", t.most_forbidden, {.minimum = 1, .maximum = 100});
  const config::Node dds = root.child("dds");
  for (const std::string& service : dds.keys()) {
    require(has_vendor(service), ErrorCode::bad_input, dds.where() + ": there is no service " + service);
    dds.read_choice(service, t.dds[service], {"fastdds", "cyclonedds"});
  }
  const config::Node instances = root.child("instances");
  for (const std::string& service : instances.keys()) {
    require(std::find(kStateless.begin(), kStateless.end(), service) != kStateless.end(), ErrorCode::bad_input,
            instances.where() + ": " + service + " runs once; there may be several of nbv_planner, posture_generator and walk_planner");
    instances.read(service, t.instances[service], {.minimum = 1, .maximum = kMostOfAService});
  }
  root.read("output", t.output);
  object.finish();
  stop.finish();
  root.finish();
  return t;
}

Task load_task(const std::string& path) {
  return read_task(config::load_file(path), fs::absolute(path).parent_path().string());
}

std::string Task::yaml() const {
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  const auto vector = [&out](const Eigen::Vector3d& v) { out << YAML::Flow << YAML::BeginSeq << v.x() << v.y() << v.z() << YAML::EndSeq; };
  const auto put = [&out](const char* key, const auto& value) { out << YAML::Key << key << YAML::Value << value; };
  out << YAML::BeginMap;
  put("schema", 1);
  put("name", name);
  put("robot", robot);
  put("scene", scene);
  out << YAML::Key << "object" << YAML::Value << YAML::BeginMap;
  put("id", object_id);
  out << YAML::Key << "box_center_m" << YAML::Value;
  vector(box.X_WB.translation());
  out << YAML::Key << "box_size_m" << YAML::Value;
  vector(box.size);
  put("box_yaw_rad", yaw_pitch_roll(box.X_WB.linear())[0]);
  out << YAML::EndMap;
  put("voxel_m", voxel_m);
  out << YAML::Key << "stop" << YAML::Value << YAML::BeginMap;
  put("least_gain_voxels", stop.least_gain_voxels);
  put("discount_looks", stop.discount_looks);
  put("variation_voxels", stop.variation_voxels);
  put("most_looks", stop.most_looks);
  put("most_time_s", stop.most_time_s);
  out << YAML::EndMap;
  put("seed", seed);
  put("motion_mode", motion_mode);
  put("truth", truth);
  put("most_forbidden", most_forbidden);
  if (!dds.empty()) {
    out << YAML::Key << "dds" << YAML::Value << YAML::BeginMap;
    for (const auto& [service, vendor_name] : dds) put(service.c_str(), vendor_name);
    out << YAML::EndMap;
  }
  if (!instances.empty()) {
    out << YAML::Key << "instances" << YAML::Value << YAML::BeginMap;
    for (const auto& [service, number] : instances) put(service.c_str(), number);
    out << YAML::EndMap;
  }
  put("output", output);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace periplus::supervisor
