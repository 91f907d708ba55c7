// A situation out of files: model, camera, scene.
#pragma once

#include <string>
#include <vector>

#include "services/nbv_planner/settings.h"
#include "services/nbv_planner/situation.h"
#include "services/nbv_planner/tool/camera_file.h"

namespace periplus::nbv {

struct PlanInput {
  Situation situation;
  Settings settings;       // with what the camera's file says instead
  std::string object_id, camera_name, scene_name;
};

// `scene`: a file that goes before the camera's own; empty: the camera's, or free space without walls. Forbidden poses are left
// eye poses; the camera is where the model's last view was taken from, and the model's views are those of the situation. Throws
// Error with what to do: a file that is missing or no model, camera or scene; limits that are no interval.
PlanInput read_input(const std::string& model_file, const std::string& camera_file, const std::string& scene,
                     const std::vector<Pose>& forbidden, const Settings& settings);

}  // namespace periplus::nbv
