// periplus-evaluate RUN_FOLDER: holds a run against the truth that the simulator told, and adds to its report.json
// coverage_reachable, coverage_visible (after each look as coverage, coverage_visible), surface_error both ways, truth.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/mesh/triangle_mesh.h"
#include "common/mesh/triangle_tree.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "integration-tests/evaluation/coverage.h"
#include "integration-tests/evaluation/obstacles.h"

namespace {

using namespace periplus;
using namespace periplus::evaluation;
using nlohmann::json;

constexpr std::size_t sample_count = 20000;
constexpr int visible_directions = 300;
constexpr double head_radius = 0.15;  // [m] about the middle between the eyes

json read_json(const std::string& path) { return json::parse(read_file(path)); }

json to_json(const ErrorStatistics& e) { return {{"mean", e.mean}, {"p95", e.p95}, {"max", e.max}}; }

void evaluate(const std::string& folder) {
  json report = read_json(folder + "/report.json");
  json truth = read_json(folder + "/truth.json");
  const mesh::TriangleMesh object = mesh::load(folder + "/truth.ply");
  const mesh::TriangleTree tree(object);
  const scene::Scene scene = scene::load_scene(folder + "/scene.yaml");
  const Obstacles obstacles(scene);
  const auto robot = robot::RobotModel::load_files(folder + "/robot.urdf", folder + "/robot.yaml");

  SurfaceSamples samples;
  for (const mesh::SurfaceSample& s : mesh::sample_surface(object, sample_count, 1)) {
    samples.points.push_back(s.point);
    samples.normals.push_back(s.normal);
  }
  const Blocked blocked = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    return tree.ray(p, q - p, 1.0).has_value() || obstacles.block(p, q);
  };

  // Where the half-sitting robot's base stands when its left eye is somewhere: the head may turn and bend, the base stays
  // about as far behind the eye as in half-sitting.
  robot::Kinematics kinematics(robot);
  kinematics.set(robot->half_sitting());
  const Pose X_WC0 = kinematics.X_WC("left");
  const Eigen::Vector2d eye_in_base = X_WC0.translation().head<2>();
  const robot::BodyBox& body = robot->body_box();
  const Eigen::Vector3d body_size = body.upper - body.lower;
  const Stands stands = [&](const Pose& X_WC) {
    const double yaw = camera_yaw_pitch_roll(X_WC)[0];
    const Pose X_WF = to_pose({X_WC.translation().x() - std::cos(yaw) * eye_in_base.x() + std::sin(yaw) * eye_in_base.y(),
                               X_WC.translation().y() - std::sin(yaw) * eye_in_base.x() - std::cos(yaw) * eye_in_base.y(), yaw});
    Pose X_WB = X_WF;
    X_WB.translation() += X_WF.linear() * (body.lower + body.upper) / 2;
    if (obstacles.touch_box(X_WB, body_size) || box_holds_sample(samples, X_WB, body_size)) return false;
    return !obstacles.touch_ball(X_WC * Eigen::Vector3d(robot->stereo_rig().baseline / 2, 0, 0), head_radius);
  };

  const ReachOptions options;
  const std::vector<Pose> poses = reachable_poses(samples, options, stands);
  const std::vector<bool> reachable = reachable_samples(samples, robot->stereo_rig(), poses, options, blocked);
  const std::vector<bool> visible = visible_samples(samples, visible_directions, options.incidence_max, 1, blocked);
  const std::vector<bool> all(samples.points.size(), true);

  const RunCoverage run = cover_looks(folder, report.at("looks"), samples, reachable, visible);
  for (const std::string& sentence : run.skipped) std::fprintf(stderr, "periplus-evaluate: a look is left out: %s\n", sentence.c_str());
  report["coverage_reachable"] = run.reachable;
  report["coverage_visible"] = run.visible;
  report["coverage_all"] = run.all;
  report["reachable_share"] = share(reachable, all);
  report["visible_share"] = share(visible, all);
  report["evaluation"] = {{"samples", samples.points.size()}, {"poses", poses.size()}, {"skipped_looks", run.skipped}};

  if (std::filesystem::exists(folder + "/model.ply")) {
    const mesh::TriangleMesh model = mesh::load(folder + "/model.ply");
    const mesh::TriangleTree model_tree(model);
    std::vector<double> to_truth, to_model;
    for (const mesh::SurfaceSample& s : mesh::sample_surface(model, sample_count, 2)) to_truth.push_back(tree.closest(s.point).distance);
    for (std::size_t i = 0; i < samples.points.size(); ++i)
      if (reachable[i]) to_model.push_back(model_tree.closest(samples.points[i]).distance);
    report["surface_error"] = {{"model_to_truth", to_json(statistics(to_truth))}, {"truth_to_model", to_json(statistics(to_model))}};
  }
  report["truth"] = truth;
  std::ofstream file(folder + "/report.json");
  file << report.dump(1) << "\n";
  file.close();
  require(file.good(), ErrorCode::io, "cannot write " + folder + "/report.json");

  std::printf("coverage of the reachable surface %.1f %%, of the visible %.1f %%", 100 * run.reachable, 100 * run.visible);
  if (report.contains("surface_error"))
    std::printf("; surface error mean %.1f mm, p95 %.1f mm", 1000 * report["surface_error"]["model_to_truth"]["mean"].get<double>(),
                1000 * report["surface_error"]["model_to_truth"]["p95"].get<double>());
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fprintf(stderr, "usage: periplus-evaluate RUN_FOLDER\nHolds a run against the simulator's truth and adds the result to its report.json.\n");
    return 2;
  }
  try {
    evaluate(argv[1]);
    return 0;
  } catch (const periplus::Error& e) {
    std::fprintf(stderr, "periplus-evaluate: %s\n", e.what());
  } catch (const nlohmann::json::exception& e) {
    std::fprintf(stderr, "periplus-evaluate: a file of %s is damaged: %s\n", argv[1], e.what());
  }
  return 2;
}
