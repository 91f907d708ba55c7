#include "integration-tests/nbv_benchmark/arena.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/object_model/object_model.h"
#include "services/nbv_planner/constraints.h"

namespace periplus::nbv_benchmark {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRoom = 8;                 // side of the room in which an object floats [m]
constexpr double kTable = 0.7;              // side and height of the table [m]
constexpr double kTableTolerance = 0.004;   // CarvingSettings::solid_tolerance_m
constexpr double kNear = 0.6, kFar = 2.5;   // to the surface [m]
constexpr int kDraws = 500;                 // for each candidate that is wanted

Eigen::Vector3d direction(Random& random) {
  const double z = random.uniform(-1, 1), a = random.uniform(-kPi, kPi), r = std::sqrt(1 - z * z);
  return {r * std::cos(a), r * std::sin(a), z};
}

// Evenly over the upper half of the sphere (Fibonacci spiral), 5 degrees above the horizon and more.
std::vector<Pose> dome(const Eigen::Vector3d& middle, double distance, int count) {
  std::vector<Pose> poses;
  const double golden = kPi * (3 - std::sqrt(5.0)), lowest = std::sin(5 * kPi / 180);
  for (int i = 0; i < count; ++i) {
    const double z = lowest + (1 - lowest) * (i + 0.5) / count, r = std::sqrt(1 - z * z), a = golden * i;
    poses.push_back(look_at(middle + distance * Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z), middle));
  }
  return poses;
}

// From all sides, at least `kNear` from the surface, looking at some place of the inner half of the box.
std::vector<Pose> all_around(const Subject& s, const Arena& arena, int count, Random& random) {
  std::vector<Pose> poses;
  const mesh::Bounds b = mesh::bounds(s.mesh);
  const double reach = b.size().norm() / 2;
  for (int draw = 0; draw < kDraws * count && static_cast<int>(poses.size()) < count; ++draw) {
    const Eigen::Vector3d p_O = direction(random) * random.uniform(kNear, kFar + reach);
    const Eigen::Vector3d half = b.size() / 4;
    const Eigen::Vector3d target(random.uniform(-half.x(), half.x()), random.uniform(-half.y(), half.y()), random.uniform(-half.z(), half.z()));
    const double distance = s.tree->closest(p_O).distance;
    if (distance < kNear || distance > kFar) continue;
    poses.push_back(look_at(arena.X_WO * p_O, arena.X_WO * target));
  }
  return poses;
}

// Where the robot can stand and look, the object being as it is; near views as frequent as far ones (thesis 3.3.2).
std::vector<Pose> robot_views(const Subject& s, const Arena& arena, int count, Random& random) {
  const nbv::Situation truth = situation_of(arena, std::make_shared<voxel::OccupancyGrid>(true_grid(s, arena.X_WO)));
  const voxel::VisibilityScene visibility(*truth.grid);
  const nbv::Constraints constraints(truth, visibility, {});
  const mesh::Bounds b = mesh::bounds(s.mesh);
  const Eigen::Vector3d middle = arena.X_WO.translation(), half = b.size() / 2;
  const robot::ViewLimits& l = arena.limits;
  std::vector<Pose> poses;
  for (int draw = 0; draw < kDraws * count && static_cast<int>(poses.size()) < count; ++draw) {
    const double angle = random.uniform(-kPi, kPi), r = random.uniform(l.distance_min, l.distance_max + half.head<2>().norm());
    const double z = std::clamp(random.uniform(1.2 * l.height_min - 0.2 * l.height_max, 1.2 * l.height_max - 0.2 * l.height_min), l.height_min, l.height_max);
    const Eigen::Vector3d p(middle.x() + r * std::cos(angle), middle.y() + r * std::sin(angle), z);
    const Eigen::Vector3d d = middle + Eigen::Vector3d(random.uniform(-half.x(), half.x()), random.uniform(-half.y(), half.y()), random.uniform(-half.z(), half.z())) - p;
    const double pitch = std::clamp(std::atan2(-d.z(), std::hypot(d.x(), d.y())), l.pitch_min, l.pitch_max);
    // The middle between the eyes looks there.
    Pose X_WC = look_along(p, std::atan2(d.y(), d.x()), pitch);
    if (arena.pair) X_WC.translation() = X_WC * Eigen::Vector3d(-arena.rig.baseline / 2, 0, 0);
    if (constraints.check(X_WC) == nbv::Violation::none) poses.push_back(X_WC);
  }
  return poses;
}

}  // namespace

const char* to_string(PoseSet set) { return set == PoseSet::dome ? "dome" : set == PoseSet::free ? "free" : "reachable"; }
const char* to_string(Camera camera) { return camera == Camera::single ? "single" : "pair"; }

Pinhole single_camera() {
  Pinhole c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 320 / std::tan(30 * kPi / 180);
  c.cx = 319.5;
  c.cy = 239.5;
  return c;
}

Arena make_arena(const Subject& s, const ArenaOptions& o) {
  require(o.robot != nullptr || (o.camera == Camera::single && o.set != PoseSet::reachable), ErrorCode::bad_input,
          "the robot's pair and its reachable poses need a robot; name one with --robot");
  require(o.candidates > 0 && o.dome_views > 0, ErrorCode::bad_input, "a pose set needs at least one pose");
  Arena a;
  a.set = o.set;
  a.pair = o.camera == Camera::pair;
  a.rig = a.pair ? o.robot->stereo_rig() : StereoRig{single_camera(), 0};
  const mesh::Bounds b = mesh::bounds(s.mesh);
  if (o.set == PoseSet::reachable) {
    scene::Solid table;
    table.name = "table";
    table.size = Eigen::Vector3d::Constant(kTable);
    table.X_WS = make_pose({0, 0, kTable / 2}, Eigen::Matrix3d::Identity());
    table.texture = "noise:41";
    table.supports_object = true;
    a.scene.solids.push_back(table);
    a.scene.room.size = {6, 6, 2.8};
    a.X_WO.translation() = Eigen::Vector3d(0, 0, kTable + b.size().z() / 2);
    a.box.X_WB.translation() = Eigen::Vector3d(0, 0, kTable + s.box_side / 2);
    a.limits = o.robot->view_limits();
    a.body = o.robot->body_box();
    a.truth.add(mesh::make_box(table.size, 1), table.X_WS);
  } else {
    a.scene.room.size = {kRoom, kRoom, kRoom};
    a.X_WO.translation() = Eigen::Vector3d(0, 0, kRoom / 2);
    a.box.X_WB = a.X_WO;
    a.limits.height_min = 0;
    a.limits.height_max = kRoom;
    a.limits.pitch_min = -kPi / 2;
    a.limits.pitch_max = kPi / 2;
    a.limits.roll_max = kPi;
    a.limits.distance_min = kNear;
    a.limits.distance_max = kFar;
    a.body = {Eigen::Vector3d(-0.01, -0.01, 0), Eigen::Vector3d(0.01, 0.01, 0.01)};  // a camera alone
  }
  a.scene.name = to_string(o.set);
  a.scene.room.wall_texture = "noise:20";
  a.scene.room.floor_texture = "noise:30";
  a.scene.lights = {{{0.6, 0.5, a.scene.room.size.z() - 0.1}, 0.5}, {{-2, -2, a.scene.room.size.z() - 0.1}, 0.35}, {{2, -1.5, a.scene.room.size.z() - 0.1}, 0.3}};
  a.box.size = Eigen::Vector3d::Constant(s.box_side);
  a.collision = std::make_shared<scene::CollisionWorld>(a.scene);
  a.truth.add(s.mesh, a.X_WO);

  Random random(o.seed);
  switch (o.set) {
    case PoseSet::dome: a.candidates = dome(a.X_WO.translation(), o.dome_distance, o.dome_views); break;
    case PoseSet::free: a.candidates = all_around(s, a, o.candidates, random); break;
    case PoseSet::reachable: a.candidates = robot_views(s, a, o.candidates, random); break;
  }
  require(!a.candidates.empty(), ErrorCode::bad_input, s.file.name + ": no pose of the set '" + to_string(o.set) + "' is possible with this object and robot");

  std::vector<Eigen::Vector3d> points, normals;
  for (const mesh::SurfaceSample& p : s.samples) {
    points.push_back(p.point);
    normals.push_back(p.normal);
  }
  std::vector<const mesh::TriangleTree*> occluders = {s.tree.get()};
  std::unique_ptr<mesh::TriangleTree> solids;
  if (!a.scene.solids.empty()) {
    mesh::TriangleMesh table = mesh::make_box(a.scene.solids.front().size, 1);
    mesh::transform(table, a.X_WO.inverse() * a.scene.solids.front().X_WS);
    solids = std::make_unique<mesh::TriangleTree>(table);
    occluders.push_back(solids.get());
  }
  a.visible = Mask(points.size());
  a.visible_voxels = Mask(s.voxel_points.size());
  for (const Pose& X_WC : a.candidates) {
    const Pose X_OC = a.X_WO.inverse() * X_WC;
    Viewer viewer{a.rig.camera, {X_OC}};
    if (a.pair) viewer.X_SC.push_back(X_OC * Pose(Eigen::Translation3d(a.rig.baseline, 0, 0)));
    add_visible(points, normals, occluders, viewer, a.visible);
    add_visible(s.voxel_points, s.voxel_normals, occluders, viewer, a.visible_voxels);
  }
  return a;
}

std::optional<double> table_height_object(const Arena& a) {
  if (a.scene.solids.empty()) return std::nullopt;
  return kTable + kTableTolerance - a.X_WO.translation().z();
}

ImageF without_table(const Arena& a, const object_model::DepthMap& map) {
  const auto table = table_height_object(a);
  if (!table) return map.depth;
  ImageF depth = map.depth;
  const Pose X_OC = a.X_WO.inverse() * map.X_WC;
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u)
      if (depth.at(u, v) > 0 && (X_OC * map.camera.back_project(u, v, depth.at(u, v))).z() <= *table) depth.at(u, v) = 0;
  return depth;
}

nbv::Situation situation_of(const Arena& a, std::shared_ptr<const voxel::OccupancyGrid> grid) {
  nbv::Situation s;
  s.grid = std::move(grid);
  s.scene = a.scene;
  s.collision = a.collision;
  s.limits = a.limits;
  s.body = a.body;
  s.rig = a.rig;
  return s;
}

}  // namespace periplus::nbv_benchmark
