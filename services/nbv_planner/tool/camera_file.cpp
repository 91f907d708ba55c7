#include "services/nbv_planner/tool/camera_file.h"

#include <cmath>
#include <filesystem>
#include <numbers>

#include "common/core/config.h"
#include "common/core/error.h"
#include "common/core/file.h"

namespace periplus::nbv {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

[[noreturn]] void refuse(const config::Node& node, const std::string& sentence) {
  throw_error(ErrorCode::bad_input, node.where() + ": " + sentence);
}

// Two numbers, the first less than the second.
void read_interval(const config::Node& node, const char* key, double scale, double& low, double& high) {
  Eigen::Vector2d v;
  if (!node.read(key, v)) return;
  if (!(v.x() < v.y())) refuse(node, std::string(key) + ": [least, greatest] with least < greatest is expected");
  low = v.x() * scale;
  high = v.y() * scale;
}

int pixels(const config::Node& node, double v) {
  if (!(v >= 1 && v <= 8192) || v != std::floor(v)) refuse(node, "resolution_px: [width, height], whole numbers from 1 to 8192, are expected");
  return static_cast<int>(v);
}

Pinhole read_pinhole(const config::Node& root) {
  const auto size = root.get<Eigen::Vector2d>("resolution_px");
  const int width = pixels(root, size.x()), height = pixels(root, size.y());
  double horizontal = 0, vertical = 0;
  Eigen::Vector2d focal, center((width - 1) / 2.0, (height - 1) / 2.0);
  const bool by_horizontal = root.read("horizontal_fov_deg", horizontal, {1, 170});
  const bool by_vertical = root.read("vertical_fov_deg", vertical, {1, 170});
  const bool by_focal = root.read("focal_px", focal);
  if (root.read("center_px", center) && !by_focal) refuse(root, "center_px goes with focal_px; with a field of view the center is the image's middle");
  if (by_horizontal + by_vertical + by_focal != 1) {
    refuse(root, "exactly one of horizontal_fov_deg, vertical_fov_deg and focal_px is expected");
  }
  Pinhole camera;
  camera.width = width;
  camera.height = height;
  camera.cx = center.x();
  camera.cy = center.y();
  if (by_focal) {
    camera.fx = focal.x();
    camera.fy = focal.y();
  } else {
    camera.fx = camera.fy = by_horizontal ? width / 2.0 / std::tan(horizontal * kDegree / 2) : height / 2.0 / std::tan(vertical * kDegree / 2);
  }
  try {
    camera.check();
  } catch (const Error& e) {
    refuse(root, e.what());
  }
  return camera;
}

}  // namespace

CameraFile parse_camera(std::string_view yaml, const std::string& name) {
  const config::Node root = config::parse(yaml, name);
  std::string schema = "periplus-camera-1";
  root.read_choice("schema", schema, {"periplus-camera-1"});
  CameraFile file;
  file.name = std::filesystem::path(name).stem().string();
  root.read("name", file.name);
  file.rig.camera = read_pinhole(root);
  root.read("baseline_m", file.rig.baseline, {0, 10});

  double least = 0, greatest = 0;
  read_interval(root, "measures_m", 1, least, greatest);
  if (greatest > 0) file.measures = Eigen::Vector2d(least, greatest);
  if (least < 0 || greatest > 100) refuse(root, "measures_m: depths from 0 to 100 m are expected");
  double radius = 0;
  if (root.read("head_radius_m", radius, {0.01, 1})) file.head_radius = radius;

  const config::Node limits = root.child("limits");
  robot::ViewLimits& l = file.limits;
  read_interval(limits, "height_m", 1, l.height_min, l.height_max);
  read_interval(limits, "distance_m", 1, l.distance_min, l.distance_max);
  read_interval(limits, "pitch_deg", kDegree, l.pitch_min, l.pitch_max);
  read_interval(limits, "yaw_deg", kDegree, l.yaw_min, l.yaw_max);
  double roll = 0;
  if (limits.read("roll_deg", roll, {0, 180})) l.roll_max = roll * kDegree;

  if (root.has("body")) {
    const config::Node body = root.child("body");
    robot::BodyBox box;
    box.lower = body.get<Eigen::Vector3d>("lower_m");
    box.upper = body.get<Eigen::Vector3d>("upper_m");
    if (!(box.lower.array() < box.upper.array()).all()) refuse(body, "lower_m must be less than upper_m along each axis");
    file.body = box;
  }
  root.read("scene", file.scene);
  root.finish();
  return file;
}

CameraFile load_camera(const std::string& path) {
  CameraFile file = parse_camera(read_file(path, std::uint64_t{4} << 20), path);
  if (!file.scene.empty() && !std::filesystem::path(file.scene).is_absolute()) {
    file.scene = (std::filesystem::path(path).parent_path() / file.scene).lexically_normal().string();
  }
  return file;
}

}  // namespace periplus::nbv
