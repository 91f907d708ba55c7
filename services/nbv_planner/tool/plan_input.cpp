#include "services/nbv_planner/tool/plan_input.h"

#include <filesystem>

#include "common/core/error.h"
#include "common/object_model/model_file.h"

namespace periplus::nbv {
namespace {

object_model::ObjectModel read_model_file(const std::string& path) {
  try {
    return object_model::load_model(path);
  } catch (const Error& e) {
    if (e.code() == ErrorCode::io) throw;
    throw_error(e.code(), path + ": " + e.what() + "; a model is written by `periplus model export --format periplus`, and lies in every run's folder as model.periplus");
  }
}

}  // namespace

PlanInput read_input(const std::string& model_file, const std::string& camera_file, const std::string& scene,
                     const std::vector<Pose>& forbidden, const Settings& settings) {
  // The small files first: what is wrong there is said before much is read.
  const CameraFile camera = load_camera(camera_file);
  PlanInput input;
  input.settings = settings;
  input.camera_name = camera.name;
  Situation& s = input.situation;
  const std::string scene_file = scene.empty() ? camera.scene : scene;
  if (scene_file.empty()) {
    s.scene.room.size = {1000, 1000, 1000};  // no walls within reach
    input.scene_name = "none";
  } else {
    s.scene = scene::load_scene(scene_file);
    s.scene.truth.reset();
    input.scene_name = s.scene.name;
  }
  s.collision = std::make_shared<scene::CollisionWorld>(s.scene);
  s.rig = camera.rig;
  s.limits = camera.limits;
  s.body = camera.body.value_or(robot::BodyBox{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  s.forbidden = forbidden;
  s.reachability = settings.reachability;
  if (camera.measures) {
    input.settings.evaluation.pair.depth_min = camera.measures->x();
    input.settings.evaluation.pair.depth_max = camera.measures->y();
  }
  if (camera.head_radius) input.settings.constraints.head_radius = *camera.head_radius;

  const object_model::ObjectModel model = read_model_file(model_file);
  s.grid = std::make_shared<voxel::OccupancyGrid>(model.grid());
  s.landmarks = model.landmarks();
  input.object_id = model.state().object_id;
  for (const auto& view : model.state().views) s.views.push_back(view->X_WC);
  if (!s.views.empty()) s.X_WC_now = s.views.back();
  check(s);
  return input;
}

}  // namespace periplus::nbv
