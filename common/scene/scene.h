// The known environment: room, solids, lights, landmarks, where the robot starts; and, under `truth`, what only a
// simulator may know. From a scene YAML; units stand in the keys.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/pose.h"

namespace periplus::scene {

class MeshSolid;  // mesh_solid.h

enum class Shape { box, cylinder, sphere, mesh };

// In a scene's YAML: {name: pillar, shape: cylinder, diameter_m: 0.3, height_m: 2, position_m: [1, 0.5, 1]}, or shape: box (size_m),
// sphere (diameter_m) or mesh (mesh: tree.obj, longest_side_m: 1.5, up_axis: y); position_m is the middle, of a mesh that of its
// bounding box; yaw_deg, pitch_deg, roll_deg, texture, rgb.
struct Solid {
  std::string name;
  Shape shape = Shape::box;
  Eigen::Vector3d size{0, 0, 0};   // full side lengths of a box, or of a mesh's bounding box; (diameter, diameter, height); (diameter, ., .) [m]
  Pose X_WS = Pose::Identity();    // centre
  std::string texture;             // file name below the assets folders, or "noise:<seed>", "materials:<seed>" (made by us); empty: plain colour
  Eigen::Vector3d rgb{0.7, 0.7, 0.7};
  std::shared_ptr<const MeshSolid> mesh;  // of Shape::mesh
  bool supports_object = false;    // the table: what its top carries stands on it
};

// A room: floor at z = 0 and four walls, inner lengths along x and y about the origin.
struct Room {
  Eigen::Vector3d size{6, 6, 2.8};  // [m]
  std::string wall_texture, floor_texture;
};

struct Light {
  Eigen::Vector3d position{0, 0, 2.7};
  double intensity = 0.6;           // 0..1
};

// A textured mark of known place, for coarse localisation.
struct Landmark {
  std::string name;
  Eigen::Vector3d position, normal;
  double size = 0.1;                // [m]
};

// The object as only the simulator knows it.
struct Truth {
  std::string mesh;                 // path, name below the assets folders, or one made by us: "made:ship" (common/mesh/made_models.h)
  double longest_side = 0.45;       // [m]
  std::string up_axis = "z";        // x y z, or -x -y -z: which axis of the mesh points up
  Pose X_WO = Pose::Identity();     // of the scaled, upright mesh, whose origin is the middle of its bottom face
  std::string texture;              // as of a Solid
};

// What the simulated cameras do to their pictures; what is absent the simulator's configuration says. Distortions are k1 k2 p1 p2 k3 of
// OpenCV's plumb_bob model; empty: none. In YAML, all of them optional:
//   cameras: {noise_grey: 2, right_gain: 1.03, right_offset_grey: 2, left_distortion: [-0.2, 0.05, 0, 0, 0], right_distortion: [...], wide_distortion: [...]}
struct CameraImperfections {
  std::optional<double> noise, right_gain, right_offset;  // grey levels of 0..255
  std::vector<double> left_distortion, right_distortion, wide_distortion;
};

struct Scene {
  std::string name;
  Room room;
  std::vector<Solid> solids;
  std::vector<Light> lights;
  std::vector<Landmark> landmarks;
  CameraImperfections cameras;      // read by a simulator alone
  Pose2 robot_start;                // floor pose of the robot's base
  std::optional<Truth> truth;
};

// Throws Error(bad_input) that names file, line, key and what is expected. The meshes of solids are loaded: made ones, or files
// below the assets folders, which must be there wherever the scene is read.
Scene parse_scene(std::string_view yaml, std::string_view name);
Scene load_scene(const std::string& path);
// The same text without `truth`: what the robot may know.
std::string without_truth(std::string_view yaml);

// Closest points of a shape and the nearest solid.
struct Closest {
  double distance = 0;              // [m], negative: penetration depth (a bound)
  Eigen::Vector3d on_shape, on_solid;
  int solid = -1;                   // index into Scene::solids; -1 floor, -2.. walls
};

// Distances to the solids, the walls and (where said) the floor. Immutable: may be shared between threads.
class CollisionWorld {
 public:
  explicit CollisionWorld(const Scene& scene);
  ~CollisionWorld();
  CollisionWorld(CollisionWorld&&) noexcept;

  // Segment a-b swollen by `radius`; walls and solids, without the floor. Nothing nearer than `range`: distance = range.
  Closest capsule_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius, double range) const;
  // To one solid.
  Closest capsule_distance_to(int solid, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius) const;
  // A box, full side lengths, at X_WB: true if it touches a solid or a wall (not the floor).
  bool box_collides(const Pose& X_WB, const Eigen::Vector3d& size) const;
  // True if the point lies in a solid (grown by `margin`).
  bool contains(const Eigen::Vector3d& p, double margin = 0) const;
  // The same, or in the floor or less than `margin` above it.
  bool contains_or_floor(const Eigen::Vector3d& p, double margin = 0) const;
  // True if the axis-aligned-in-its-frame box at X_WB touches any solid: to label voxels.
  bool box_touches_solid(const Pose& X_WB, const Eigen::Vector3d& size) const;
  // First hit of the segment from p to q with a solid, as share of the way in 0..1; nothing if free.
  std::optional<double> first_hit(const Eigen::Vector3d& p, const Eigen::Vector3d& q) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::scene
