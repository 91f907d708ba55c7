#include "common/wire/object_wire.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/core/error.h"
#include "common/core/hash.h"
#include "common/wire/common_wire.h"

namespace periplus::wire {

namespace {

std::vector<std::uint8_t> plane_to_wire(const std::vector<std::uint64_t>& words) {
  std::vector<std::uint8_t> octets(words.size() * 8);
  for (std::size_t w = 0; w < words.size(); ++w)
    for (std::size_t b = 0; b < 8; ++b) octets[w * 8 + b] = static_cast<std::uint8_t>(words[w] >> (8 * b));
  return octets;
}

std::vector<std::uint64_t> plane_from_wire(const std::vector<std::uint8_t>& octets, std::size_t words, const char* what) {
  require(octets.size() == words * 8, ErrorCode::bad_size,
          std::string("plane `") + what + "` needs " + std::to_string(words * 8) + " octets for this grid, got " +
              std::to_string(octets.size()));
  std::vector<std::uint64_t> plane(words);
  for (std::size_t w = 0; w < words; ++w)
    for (std::size_t b = 0; b < 8; ++b) plane[w] |= static_cast<std::uint64_t>(octets[w * 8 + b]) << (8 * b);
  return plane;
}

}  // namespace

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

msg::ObjectGrid object_to_wire(std::string_view object_id, const voxel::OccupancyGrid& grid,
                               const std::vector<object_model::Landmark>& landmarks, const std::vector<Pose>& views) {
  check_id(object_id, "the object's id");
  require(landmarks.size() <= 65536, ErrorCode::bad_size, "an object takes at most 65536 landmarks on the wire");
  const voxel::GridGeometry& g = grid.geometry();
  msg::ObjectGrid m;
  m.object_id(std::string(object_id));
  m.revision(grid.revision);
  m.pose_world_grid(to_wire(g.X_WG));
  m.voxel_m(g.voxel_size);
  m.nx(static_cast<std::uint32_t>(g.size.x()));
  m.ny(static_cast<std::uint32_t>(g.size.y()));
  m.nz(static_cast<std::uint32_t>(g.size.z()));
  m.occupied(plane_to_wire(grid.occupied()));
  m.known(plane_to_wire(grid.known()));
  m.environment(plane_to_wire(grid.environment()));
  m.landmarks().reserve(landmarks.size());
  for (const object_model::Landmark& l : landmarks) {
    msg::Landmark w;
    w.position(to_wire(l.p_W));
    w.normal(to_wire(l.normal_W));
    w.size_m(static_cast<float>(l.size_m));
    m.landmarks().push_back(w);
  }
  for (std::size_t n = views.size() - std::min(views.size(), kViewsOnWire); n < views.size(); ++n) m.views().push_back(to_wire(views[n]));
  return m;
}

KnownObject object_from_wire(const msg::ObjectGrid& m) {
  KnownObject o;
  o.object_id = id_from_wire(m.object_id(), "the object's id");
  o.revision = m.revision();
  require(m.nx() <= 512 && m.ny() <= 512 && m.nz() <= 512, ErrorCode::bad_size,
          "a grid has at most 512 voxels along each axis");
  voxel::GridGeometry g;
  g.X_WG = from_wire(m.pose_world_grid());
  g.voxel_size = m.voxel_m();
  g.size = Eigen::Vector3i(static_cast<int>(m.nx()), static_cast<int>(m.ny()), static_cast<int>(m.nz()));
  g.check();
  // The planes' lengths are compared before a grid of the claimed size is allocated.
  const Eigen::Vector3i nb = g.bricks();
  const std::size_t words = static_cast<std::size_t>(nb.x()) * static_cast<std::size_t>(nb.y()) * static_cast<std::size_t>(nb.z()) * 8;
  auto occupied = plane_from_wire(m.occupied(), words, "occupied");
  auto known = plane_from_wire(m.known(), words, "known");
  auto environment = plane_from_wire(m.environment(), words, "environment");
  auto grid = std::make_shared<voxel::OccupancyGrid>(g);
  grid->revision = m.revision();
  grid->adopt(std::move(occupied), std::move(known), std::move(environment));
  o.grid = std::move(grid);
  require(m.landmarks().size() <= 65536, ErrorCode::bad_size, "an object takes at most 65536 landmarks");
  o.landmarks.reserve(m.landmarks().size());
  for (const msg::Landmark& w : m.landmarks()) {
    object_model::Landmark l{from_wire(w.position()), from_wire(w.normal()), static_cast<double>(w.size_m())};
    require(std::isfinite(l.size_m) && l.size_m >= 0, ErrorCode::not_finite, "a landmark's size must be a finite number of metres");
    o.landmarks.push_back(l);
  }
  require(m.views().size() <= kViewsOnWire, ErrorCode::bad_size, "an object takes at most " + std::to_string(kViewsOnWire) + " views");
  o.views.reserve(m.views().size());
  for (const msg::Pose& X_WC : m.views()) o.views.push_back(from_wire(X_WC));
  return o;
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
