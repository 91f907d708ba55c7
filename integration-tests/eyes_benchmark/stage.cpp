#include "integration-tests/eyes_benchmark/stage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/mesh/assets.h"
#include "common/render/renderer.h"
#include "integration-tests/eyes_benchmark/pictures.h"
#include "services/simulator/camera_sensor.h"

namespace periplus::eyes_benchmark {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kBoxMargin = 0.03;     // [m]
constexpr double kVisibleSlack = 0.0015;  // between two pixels of a slanted surface [m]
constexpr int kSamplesPerPixel = 4;     // against jagged edges, which no lens makes

scene::Scene room_with_table() {
  scene::Scene s;
  s.name = "eyes";
  s.room.size = {6, 6, 3};
  s.room.wall_texture = "noise:20";
  s.room.floor_texture = "noise:30";
  s.lights = {{{0.6, 0.5, 2.9}, 0.5}, {{-2, -2, 2.9}, 0.35}, {{2, -1.5, 2.9}, 0.3}};
  scene::Solid top;
  top.name = "table";
  top.size = {0.9, 0.9, 0.04};
  top.X_WS.translation() = Eigen::Vector3d(0, 0, kTable - 0.02);
  top.texture = "noise:41";
  top.supports_object = true;
  s.solids.push_back(top);
  scene::Solid leg;
  leg.name = "leg";
  leg.shape = scene::Shape::cylinder;
  leg.size = {0.1, 0.1, kTable - 0.04};
  leg.X_WS.translation() = Eigen::Vector3d(0, 0, (kTable - 0.04) / 2);
  leg.texture = "noise:41";
  s.solids.push_back(leg);
  return s;
}

scene::Truth truth_of(const std::string& file, double longest_side) {
  scene::Truth t;
  t.mesh = file;
  t.longest_side = longest_side;
  t.up_axis = "y";
  t.X_WO.translation() = Eigen::Vector3d(0, 0, kTable);
  return t;
}

Pose left_eye_at(const Eigen::Vector3d& target, double azimuth, double height, double baseline) {
  const double dz = height - target.z(), r = std::sqrt(kDistance * kDistance - dz * dz);
  const Pose middle = look_at({target.x() + r * std::cos(azimuth), target.y() + r * std::sin(azimuth), height}, target);
  return middle * Eigen::Translation3d(-baseline / 2, 0, 0);
}

}  // namespace

StereoRig robot_eyes() { return {Pinhole::from_vertical_fov(640, 480, 25 * kPi / 180), 0.144}; }

const char* to_string(Paint paint) {
  switch (paint) {
    case Paint::rich: return "rich";
    case Paint::weak: return "weak";
    case Paint::none: return "none";
    case Paint::own: break;
  }
  return "own";
}

Stage make_stage(const std::string& object, mesh::TriangleMesh mesh_W) {
  Stage s;
  s.object = object;
  s.scene = room_with_table();
  s.solids = std::make_shared<scene::CollisionWorld>(s.scene);
  s.surroundings = {"", s.solids, object_model::occluders_of(s.scene)};
  s.mesh_W = std::move(mesh_W);
  if (mesh::signed_volume(s.mesh_W) < 0) mesh::flip(s.mesh_W);
  s.tree = std::make_shared<mesh::TriangleTree>(s.mesh_W);
  const mesh::Bounds b = mesh::bounds(s.mesh_W);
  s.middle = (b.lower + b.upper) / 2;
  // Whole centimetres, so that no layer of voxels reaches into the table.
  const auto whole = [](double side) { return std::ceil(side * 50 - 1e-9) / 50; };
  const Eigen::Vector3d size = b.size();
  s.box.size = {whole(size.x() + 2 * kBoxMargin), whole(size.y() + 2 * kBoxMargin), whole(size.z() + kBoxMargin)};
  s.box.X_WB.translation() = Eigen::Vector3d(s.middle.x(), s.middle.y(), kTable + s.box.size.z() / 2);
  s.alone.add(s.mesh_W, Pose::Identity());
  s.with_table.add(s.mesh_W, Pose::Identity());
  const scene::Solid &top = s.scene.solids[0], &leg = s.scene.solids[1];
  s.with_table.add(mesh::make_box(top.size, 1), top.X_WS);
  s.with_table.add(mesh::make_cylinder(leg.size.x(), leg.size.z(), 1), leg.X_WS);
  return s;
}

Stage make_stage(const std::string& object, const std::string& file, double longest_side) {
  return make_stage(object, render::load_true_object(truth_of(file, longest_side)).mesh_W);
}

std::vector<Pose> six_views(const Stage& stage) {
  constexpr double kHeights[] = {1.25, 1.05, 1.4};
  std::vector<Pose> poses;
  for (int i = 0; i < 6; ++i) poses.push_back(left_eye_at(stage.middle, (20 + 60 * i) * kPi / 180, kHeights[i % 3], robot_eyes().baseline));
  return poses;
}

std::vector<Pose> turned_views(const Stage& stage, const std::vector<double>& degrees) {
  std::vector<Pose> poses;
  for (const double d : degrees) poses.push_back(left_eye_at(stage.middle, (20 + d) * kPi / 180, 1.25, robot_eyes().baseline));
  return poses;
}

EyeTruth true_eye(const Stage& stage, const Pinhole& camera, const Pose& X_WC) {
  EyeTruth t{X_WC, stage.with_table.render(X_WC, camera, kBackground), ImageU8(camera.width, camera.height)};
  const ImageF alone = stage.alone.render(X_WC, camera, 0);
  for (std::size_t i = 0; i < alone.data.size(); ++i) t.object.data[i] = alone.data[i] > 0 && alone.data[i] <= t.depth.data[i] ? 255 : 0;
  return t;
}

std::vector<Shot> take_pictures(const Stage& stage, const std::string& file, double longest_side, Paint paint, const SensorSettings& sensor,
                                const std::vector<Pose>& poses) {
  scene::Truth truth = truth_of(file, longest_side);
  truth.texture = paint == Paint::own ? file.substr(0, file.rfind('.')) + ".png" : "noise:5";
  render::TrueObject object = render::load_true_object(truth);
  if (paint == Paint::weak) object.picture = weak_texture(3072, 2048, 6);
  if (paint == Paint::none) object.picture = plain_picture({175, 160, 140});
  render::RendererOptions options;
  options.samples = kSamplesPerPixel;
  render::Renderer renderer(stage.scene, {object}, options);
  const StereoRig rig = robot_eyes();
  std::vector<Shot> shots;
  for (const Pose& X_WC : poses) {
    Shot shot;
    const Pose X_WR = X_WC * Eigen::Translation3d(rig.baseline, 0, 0);
    shot.pair.rig = rig;
    shot.pair.X_WC = X_WC;
    shot.pair.left = renderer.render(X_WC, rig.camera).colour;
    shot.pair.right = renderer.render(X_WR, rig.camera).colour;
    const std::string view = std::to_string(shots.size());
    simulator::expose(shot.pair.left, {1, 0, sensor.noise}, simulator::picture_seed(sensor.seed, view, "left"));
    simulator::expose(shot.pair.right, {sensor.right_gain, sensor.right_offset, sensor.noise}, simulator::picture_seed(sensor.seed, view, "right"));
    shot.pair.left_grey = to_grey(shot.pair.left);
    shot.pair.right_grey = to_grey(shot.pair.right);
    shot.left = true_eye(stage, rig.camera, X_WC);
    shot.right = true_eye(stage, rig.camera, X_WR);
    shots.push_back(std::move(shot));
  }
  return shots;
}

std::vector<Eigen::Vector3d> visible_surface(const Stage& stage, std::size_t count, std::uint64_t seed) {
  std::vector<Eigen::Vector3d> open;
  for (const mesh::SurfaceSample& s : mesh::sample_surface(stage.mesh_W, count, seed))
    if (s.point.z() > kTable + kTableSkin) open.push_back(s.point);
  std::vector<Eigen::Vector3d> seen;
  const StereoRig rig = robot_eyes();
  const Pinhole& camera = rig.camera;
  for (const double height : {1.0, 1.13, 1.26, 1.4})
    for (int a = 0; a < 48; ++a) {
      const Pose X_WC = left_eye_at(stage.middle, a * 2 * kPi / 48, height, rig.baseline), X_CW = X_WC.inverse();
      const ImageF depth = stage.with_table.render(X_WC, camera, kBackground);
      std::erase_if(open, [&](const Eigen::Vector3d& p_W) {
        const Eigen::Vector3d p = X_CW * p_W;
        const Eigen::Vector2d uv = camera.project(p);
        const int u = static_cast<int>(std::lround(uv.x())), v = static_cast<int>(std::lround(uv.y()));
        if (u < 1 || v < 1 || u >= camera.width - 1 || v >= camera.height - 1 || p.z() > depth.at(u, v) + kVisibleSlack) return false;
        seen.push_back(p_W);
        return true;
      });
    }
  return seen;
}

}  // namespace periplus::eyes_benchmark
