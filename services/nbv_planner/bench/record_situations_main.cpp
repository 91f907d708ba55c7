// Records the situations of search_bench: runs of the robot's pair with ideal depth around meshes of Debian packages
// (deploy/fetch-assets.sh), each look planned by plan_view and carved as the model server does.
//
//   record_situations small|large|unseen OUTPUT       unseen: what no setting of the search was chosen on
#include <cstdio>
#include <fstream>
#include <iostream>
#include <numbers>
#include <optional>
#include <sstream>
#include <thread>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/mesh/assets.h"
#include "common/mesh/triangle_mesh.h"
#include "common/mesh/triangle_tree.h"
#include "common/object_model/object_model.h"
#include "services/nbv_planner/bench/situation_file.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv::bench {
namespace {

constexpr double kPi = std::numbers::pi;

struct Run {
  const char* name;
  const char* mesh;
  const char* up_axis;
  double size;              // longest side [m]
  double yaw_deg;
  int obstacles;
  std::vector<int> after;   // looks after which the situation is recorded
};

const std::vector<Run> kSmall = {
    {"bunny", "bunny.obj", "y", 0.5, 0, 2, {1, 2, 3, 5, 7}},
    {"triceratops", "triceratops.off", "y", 0.5, 90, 3, {1, 2, 4, 6, 8}},
    {"elephant", "elephant.off", "y", 0.5, 40, 0, {1, 2, 3, 4, 6}},
    {"cow", "cow.off", "y", 0.5, 0, 2, {1, 2, 3, 5, 8}},
    {"homer", "homer.off", "y", 0.5, 20, 0, {1, 2, 3, 4, 6}},
    {"bear", "bear.off", "y", 0.5, -60, 4, {1, 2, 3, 5, 7}},
    {"dino", "dino.off", "y", 0.5, 130, 1, {1, 2, 4, 6, 8}},
    {"mug", "mug.obj", "z", 0.5, 70, 3, {1, 2, 3, 4, 5}},
};
const std::vector<Run> kLarge = {
    {"bunny-2m", "bunny.obj", "y", 2.0, 0, 0, {1, 4, 8}},
    {"elephant-2m", "elephant.off", "y", 2.0, 30, 3, {2, 5, 9}},
    {"triceratops-2m", "triceratops.off", "y", 2.0, 90, 0, {1, 3, 7}},
    {"cow-2m", "cow.off", "y", 2.0, 45, 4, {2, 4, 8}},
};

const std::vector<Run> kUnseen = {
    {"lion", "lion.off", "y", 0.5, 110, 2, {1, 2, 3, 5, 7}},
    {"dog", "dog.obj", "y", 0.5, -30, 1, {1, 2, 3, 4, 6}},
    {"bunny-turned", "bunny.obj", "y", 0.5, 150, 3, {1, 2, 4, 6, 8}},
    {"elephant-turned", "elephant.off", "y", 0.5, -140, 2, {1, 2, 3, 5, 7}},
};

std::string scene_of(const Run& run, std::uint64_t seed) {
  Random random(seed);
  const bool large = run.size > 1;
  std::ostringstream yaml;
  yaml.precision(4);
  yaml << std::fixed << "schema: periplus-scene-1\nname: " << run.name << "\n"
       << "room: {size_m: " << (large ? "[9.0, 9.0, 3.2]" : "[6.0, 6.0, 2.8]") << "}\nsolids:\n";
  if (!large) yaml << "  - {name: table, shape: box, size_m: [0.7, 0.7, 0.7], position_m: [0, 0, 0.35], supports_object: true}\n";
  for (int i = 0; i < run.obstacles; ++i) {
    const double angle = random.uniform(-kPi, kPi), r = (large ? 2.3 : 1.0) + random.uniform(0, 0.6), h = random.uniform(0.9, 1.9);
    yaml << "  - {name: obstacle" << i << ", shape: box, size_m: [" << random.uniform(0.1, 0.5) << ", " << random.uniform(0.1, 0.5) << ", " << h
         << "], position_m: [" << r * std::cos(angle) << ", " << r * std::sin(angle) << ", " << h / 2 << "], yaw_deg: " << random.uniform(-90, 90)
         << "}\n";
  }
  yaml << "robot_start: {x_m: -2, y_m: 0, yaw_deg: 0}\n";
  return yaml.str();
}

// Where a ray enters a box that is turned about the vertical, or infinity.
double enter_box(const scene::Solid& solid, const Eigen::Vector3d& p_W, const Eigen::Vector3d& d_W) {
  const Eigen::Vector3d p = solid.X_WS.inverse() * p_W, d = solid.X_WS.linear().transpose() * d_W;
  double first = 0, last = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double half = solid.size[a] / 2;
    if (std::abs(d[a]) < 1e-12) {
      if (std::abs(p[a]) > half) return std::numeric_limits<double>::infinity();
      continue;
    }
    const double t0 = (-half - p[a]) / d[a], t1 = (half - p[a]) / d[a];
    first = std::max(first, std::min(t0, t1));
    last = std::min(last, std::max(t0, t1));
  }
  return first <= last ? first : std::numeric_limits<double>::infinity();
}

object_model::DepthMap depth_of(const mesh::TriangleTree& tree, const scene::Scene& scene, const Pinhole& camera, const Pose& X_WC) {
  object_model::DepthMap map;
  map.camera = camera;
  map.X_WC = X_WC;
  map.depth = ImageF(camera.width, camera.height);
  const Eigen::Vector3d eye = X_WC.translation();
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d d = X_WC.linear() * camera.back_project(u, v, 1);
      double z = d.z() < 0 ? -eye.z() / d.z() : std::numeric_limits<double>::infinity();
      for (int a = 0; a < 2; ++a) z = std::min(z, (scene.room.size[a] / 2 - std::copysign(1.0, d[a]) * eye[a]) / std::max(std::abs(d[a]), 1e-9));
      for (const scene::Solid& s : scene.solids) z = std::min(z, enter_box(s, eye, d));
      if (const auto hit = tree.ray(eye, d, z)) z = std::min(z, hit->t);
      map.depth.at(u, v) = static_cast<float>(std::min(z, 20.0));
    }
  }
  map.depth_minimum = map.depth;
  for (int v = 1; v + 1 < camera.height; ++v) {
    for (int u = 1; u + 1 < camera.width; ++u) {
      float& least = map.depth_minimum.at(u, v);
      for (int i = 0; i < 9; ++i) least = std::min(least, map.depth.at(u + i % 3 - 1, v + i / 3 - 1));
    }
  }
  map.depth_sigma = ImageF(camera.width, camera.height, 1, 0.001f);
  return map;
}

std::vector<RecordedSituation> record(const Run& run, std::uint64_t seed, const robot::RobotModel& robot) {
  const bool large = run.size > 1;
  const double table = large ? 0 : 0.7;
  mesh::TriangleMesh mesh = mesh::load(mesh::find_asset(run.mesh));
  mesh::scale_upright(mesh, run.size, run.up_axis);
  mesh::transform(mesh, make_pose({0, 0, table}, rotation_from_yaw_pitch_roll(run.yaw_deg * kPi / 180, 0, 0)));
  const mesh::TriangleTree tree(mesh);
  const std::string yaml = scene_of(run, seed);
  Situation s;
  s.scene = scene::parse_scene(yaml, run.name);
  s.collision = std::make_shared<scene::CollisionWorld>(s.scene);
  s.limits = robot.view_limits();
  s.body = robot.body_box();
  s.rig = robot.stereo_rig();
  // 128 voxels each way: 5 mm about an object of 0.5 m, 2 cm about one of 2 m.
  const double voxel = large ? 0.02 : 0.005, side = 128 * voxel;
  const object_model::ObjectBox box{make_pose({0, 0, table + side / 2 + (large ? 0.0 : 0.0)}, Eigen::Matrix3d::Identity()),
                                    {side, side, side}};
  const object_model::Surroundings surroundings{"recorded", s.collision, object_model::occluders_of(s.scene)};
  object_model::ObjectModel model(run.name, box, voxel, surroundings);
  std::vector<RecordedSituation> all;
  // The first look is from where the robot stands.
  Pose X_WC = look_at({large ? -2.6 : -1.2, 0, 1.25}, {0, 0, table + (large ? 0.8 : 0.25)});
  EvaluationSettings evaluation;
  if (large) evaluation.pair.more_than_pixels = 20;
  for (int look = 1; look <= run.after.back(); ++look) {
    object_model::Perception p;
    p.view_id = "look" + std::to_string(look);
    p.rig = s.rig;
    p.X_WC = X_WC;
    p.silhouette_valid_share = 1;
    const Pose X_WR = X_WC * Pose(Eigen::Translation3d(s.rig.baseline, 0, 0));
    p.depth.resize(2);
    std::jthread other([&] { p.depth[1] = depth_of(tree, s.scene, s.rig.camera, X_WR); });
    p.depth[0] = depth_of(tree, s.scene, s.rig.camera, X_WC);
    other.join();
    model.integrate(p, surroundings, {});
    s.grid = std::make_shared<voxel::OccupancyGrid>(model.grid());
    if (std::find(run.after.begin(), run.after.end(), look) != run.after.end()) {
      all.push_back({run.name + std::string("-") + std::to_string(look), look, yaml, s});
    }
    const PlannedView view = plan_view(s, seed + static_cast<std::uint64_t>(look), {}, evaluation, {});
    const voxel::Counts counts = model.grid().counts();
    std::printf("%s after %d: unknown %lu known %lu, next promises %d\n", run.name, look, static_cast<unsigned long>(counts.unknown),
                static_cast<unsigned long>(counts.known), view.evaluation.gain.voxels);
    std::fflush(stdout);
    X_WC = view.X_WC;
  }
  return all;
}

}  // namespace
}  // namespace periplus::nbv::bench

int main(int argc, char** argv) {
  using namespace periplus;
  if (argc != 3) {
    std::cerr << "usage: record_situations small|large|unseen OUTPUT\n";
    return 2;
  }
  try {
    const std::string root = PERIPLUS_SOURCE_DIR;
    const auto robot = robot::RobotModel::load_files(root + "/deploy/robots/hrp2like.urdf", root + "/deploy/robots/hrp2like.yaml");
    std::vector<nbv::bench::RecordedSituation> all;
    const std::string which = argv[1];
    std::uint64_t seed = which == "unseen" ? 5000 : 100;
    for (const auto& run : which == "large" ? nbv::bench::kLarge : which == "unseen" ? nbv::bench::kUnseen : nbv::bench::kSmall) {
      for (auto& r : nbv::bench::record(run, seed += 100, *robot)) all.push_back(std::move(r));
    }
    std::ofstream(argv[2], std::ios::binary) << nbv::bench::write_situations(all);
    std::cout << all.size() << " situations in " << argv[2] << "\n";
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "record_situations: " << e.what() << "\n";
    return 1;
  }
}
