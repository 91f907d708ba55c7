#include "integration-tests/thesis_comparisons/worlds.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::thesis_comparisons {
namespace {

using nbv_benchmark::Arena;
using nbv_benchmark::Subject;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTable = 0.7;       // side and height [m]
constexpr double kFarWall = 20;      // depth where no object is [m]
constexpr int kPosesForGreatest = 300;

World make_world(Subject subject, std::shared_ptr<const robot::RobotModel> robot, double bottom, const Eigen::Vector3d& room) {
  World w{std::move(subject), {}};
  Arena& a = w.arena;
  const double height = mesh::bounds(w.subject.mesh).size().z();
  a.set = nbv_benchmark::PoseSet::reachable;
  a.rig = {thesis_camera(), 0};
  a.limits = thesis_limits();
  a.body = robot->body_box();
  a.scene.name = "thesis";
  a.scene.room.size = room;
  a.X_WO.translation() = Eigen::Vector3d(0, 0, bottom + height / 2);
  a.box.size = Eigen::Vector3d::Constant(w.subject.box_side);
  a.box.X_WB.translation() = Eigen::Vector3d(0, 0, bottom + w.subject.box_side / 2);
  if (bottom > 0) {
    scene::Solid table;
    table.name = "table";
    table.size = {kTable, kTable, bottom};
    table.X_WS = make_pose({0, 0, bottom / 2}, Eigen::Matrix3d::Identity());
    table.supports_object = true;
    a.scene.solids.push_back(table);
    a.truth.add(mesh::make_box(table.size, 1), table.X_WS);
  }
  a.truth.add(w.subject.mesh, a.X_WO);
  a.collision = std::make_shared<scene::CollisionWorld>(a.scene);
  return w;
}

void append(mesh::TriangleMesh& to, const Eigen::Vector3d& size, const Eigen::Vector3d& center) {
  mesh::TriangleMesh box = mesh::make_box(size, 1);
  mesh::transform(box, make_pose(center, Eigen::Matrix3d::Identity()));
  const int first = static_cast<int>(to.vertices.size());
  to.vertices.insert(to.vertices.end(), box.vertices.begin(), box.vertices.end());
  for (const Eigen::Vector3i& t : box.triangles) to.triangles.push_back(t + Eigen::Vector3i::Constant(first));
}

mesh::TriangleMesh ring(double radius, double thickness) {
  mesh::TriangleMesh m;
  constexpr int kAround = 64, kAcross = 24;
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kAcross; ++j) {
      const double a = 2 * std::numbers::pi * i / kAround, b = 2 * std::numbers::pi * j / kAcross;
      const double r = radius + thickness * std::cos(b);
      m.vertices.emplace_back(r * std::cos(a), thickness * std::sin(b), r * std::sin(a));
      const auto at = [&](int u, int v) { return (i + u) % kAround * kAcross + (j + v) % kAcross; };
      m.triangles.emplace_back(at(0, 0), at(0, 1), at(1, 1));
      m.triangles.emplace_back(at(0, 0), at(1, 1), at(1, 0));
    }
  }
  return m;
}

}  // namespace

Pinhole thesis_camera() { return Pinhole::from_vertical_fov(640, 480, 25 * kDegree); }

robot::ViewLimits thesis_limits() {
  robot::ViewLimits l;
  l.height_min = 1.0;
  l.height_max = 1.39;
  l.pitch_min = -25 * kDegree;
  l.pitch_max = 60 * kDegree;
  l.roll_max = 10 * kDegree;
  l.distance_min = 0.6;
  l.distance_max = 8;
  return l;
}

nbv::EvaluationSettings thesis_evaluation() {
  nbv::EvaluationSettings e;
  e.pixels_per_voxel_share = 0;
  e.pair = {.depth_min = 0.3, .depth_max = 12, .more_than_pixels = 5};
  e.lambda_rule = nbv::LambdaRule::scaled;
  e.landmarks = false;
  return e;
}

World on_table(Subject subject, std::shared_ptr<const robot::RobotModel> robot) { return make_world(std::move(subject), std::move(robot), kTable, {6, 6, 2.8}); }

World on_floor(Subject subject, std::shared_ptr<const robot::RobotModel> robot) {
  return make_world(std::move(subject), std::move(robot), 0, {16, 16, 6});
}

std::vector<std::pair<std::string, mesh::TriangleMesh>> generated_shapes() {
  std::vector<std::pair<std::string, mesh::TriangleMesh>> all;
  all.emplace_back("ring", ring(0.4, 0.1));
  mesh::TriangleMesh box, stairs, arch;
  append(box, {1, 0.7, 0.04}, {0, 0, 0.02});
  for (const int side : {-1, 1}) {
    append(box, {1, 0.04, 0.6}, {0, 0.33 * side, 0.34});
    append(box, {0.04, 0.62, 0.6}, {0.48 * side, 0, 0.34});
  }
  for (int step = 0; step < 5; ++step) append(stairs, {0.2, 0.6, 0.2 * (step + 1)}, {0.2 * step, 0, 0.1 * (step + 1)});
  append(arch, {0.25, 0.4, 0.8}, {-0.375, 0, 0.4});
  append(arch, {0.25, 0.4, 0.8}, {0.375, 0, 0.4});
  append(arch, {1, 0.4, 0.2}, {0, 0, 0.9});
  all.emplace_back("open box", std::move(box));
  all.emplace_back("stairs", std::move(stairs));
  all.emplace_back("arch", std::move(arch));
  return all;
}

nbv_benchmark::Look look(const World& world, const Pose& X_WC) {
  object_model::DepthMap map;
  map.camera = world.arena.rig.camera;
  map.X_WC = X_WC;
  map.depth = world.arena.truth.render(X_WC, map.camera, kFarWall);
  map.depth_minimum = map.depth;
  map.depth_sigma = ImageF(map.camera.width, map.camera.height);
  nbv_benchmark::Look out;
  out.depth.push_back(std::move(map));
  return out;
}

Pose pose_around(const nbv::Evaluator& evaluator, const World& world, double azimuth, std::uint64_t seed) {
  const robot::ViewLimits& l = world.arena.limits;
  const double side = mesh::bounds(world.subject.mesh).size().head<2>().norm() / 2;
  const Eigen::Vector3d middle = world.arena.X_WO.translation();
  Random random(seed);
  for (int draw = 0; draw < 2000; ++draw) {
    const double a = azimuth + random.uniform(-0.3, 0.3), r = side + random.uniform(0.7, 1.3 + 0.6 * side);
    const Eigen::Vector3d p(middle.x() + r * std::cos(a), middle.y() + r * std::sin(a), random.uniform(l.height_min + 0.05, l.height_max - 0.05));
    const Eigen::Vector3d d = middle - p;
    const double pitch = std::clamp(std::atan2(-d.z(), std::hypot(d.x(), d.y())), l.pitch_min * 0.9, l.pitch_max * 0.9);
    const Pose X_WC = look_along(p, std::atan2(d.y(), d.x()), pitch);
    if (evaluator.constraints().check(X_WC) == nbv::Violation::none) return X_WC;
  }
  throw_error(ErrorCode::internal, world.subject.file.name + ": no feasible pose around the object");
}

std::unique_ptr<State> carved(const World& world, int views, int starts, std::uint64_t seed) {
  constexpr double kTurn = 100 * kDegree;  // from one look to the next
  auto state = std::make_unique<State>();
  state->object = world.subject.file.name;
  state->size = mesh::bounds(world.subject.mesh).size().maxCoeff();
  nbv_benchmark::Reconstruction model(world.arena, world.subject, {});
  Random random(seed);
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  for (int view = 0;; ++view) {
    state->situation = nbv_benchmark::situation_of(world.arena, std::make_shared<voxel::OccupancyGrid>(model.grid()));
    state->evaluator = std::make_unique<nbv::Evaluator>(state->situation, thesis_evaluation(), nbv::ConstraintSettings{});
    if (view == views) break;
    state->last = pose_around(*state->evaluator, world, azimuth + kTurn * view, seed + static_cast<std::uint64_t>(view));
    model.integrate(look(world, state->last));
  }
  nbv::Evaluator::Workspace workspace;
  for (int i = 0; i < kPosesForGreatest || static_cast<int>(state->starts.size()) < starts; ++i) {
    const Pose X = pose_around(*state->evaluator, world, random.uniform(0, 2 * std::numbers::pi), random.next());
    const nbv::Evaluation e = state->evaluator->evaluate(X, workspace);
    state->greatest = std::max(state->greatest, e.value);
    if (e.value > 0 && static_cast<int>(state->starts.size()) < starts) state->starts.push_back(X);
    require(i < 100 * kPosesForGreatest, ErrorCode::internal, state->object + ": nothing unknown is left to be seen");
  }
  return state;
}

}  // namespace periplus::thesis_comparisons
