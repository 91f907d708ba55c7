#include "common/core/error.h"

#include <cstdio>
#include <cstdlib>

namespace periplus {

const char* to_string(ErrorCode code) {
  switch (code) {
    case ErrorCode::ok: return "ok";
    case ErrorCode::internal: return "internal";
    case ErrorCode::bad_input: return "bad_input";
    case ErrorCode::bad_size: return "bad_size";
    case ErrorCode::not_finite: return "not_finite";
    case ErrorCode::unknown_id: return "unknown_id";
    case ErrorCode::cancelled: return "cancelled";
    case ErrorCode::not_ready: return "not_ready";
    case ErrorCode::io: return "io";
    case ErrorCode::vision_images_missing: return "vision_images_missing";
    case ErrorCode::vision_image_bad: return "vision_image_bad";
    case ErrorCode::vision_view_unknown: return "vision_view_unknown";
    case ErrorCode::vision_no_depth: return "vision_no_depth";
    case ErrorCode::vision_revision_not_here: return "vision_revision_not_here";
    case ErrorCode::model_object_unknown: return "model_object_unknown";
    case ErrorCode::model_perception_not_here: return "model_perception_not_here";
    case ErrorCode::model_environment_missing: return "model_environment_missing";
    case ErrorCode::model_store: return "model_store";
    case ErrorCode::model_object_differs: return "model_object_differs";
    case ErrorCode::nbv_no_reachable_view: return "nbv_no_reachable_view";
    case ErrorCode::nbv_revision_not_here: return "nbv_revision_not_here";
    case ErrorCode::posture_infeasible: return "posture_infeasible";
    case ErrorCode::posture_revision_not_here: return "posture_revision_not_here";
    case ErrorCode::walk_no_path: return "walk_no_path";
    case ErrorCode::walk_revision_not_here: return "walk_revision_not_here";
    case ErrorCode::walk_start_in_collision: return "walk_start_in_collision";
    case ErrorCode::walk_goal_in_collision: return "walk_goal_in_collision";
    case ErrorCode::motion_robot_fault: return "motion_robot_fault";
    case ErrorCode::motion_halted: return "motion_halted";
    case ErrorCode::motion_robot_silent: return "motion_robot_silent";
    case ErrorCode::motion_joint_limit: return "motion_joint_limit";
    case ErrorCode::motion_busy: return "motion_busy";
    case ErrorCode::motion_revision_not_here: return "motion_revision_not_here";
    case ErrorCode::supervisor_busy: return "supervisor_busy";
    case ErrorCode::supervisor_bad_task: return "supervisor_bad_task";
    case ErrorCode::supervisor_no_such_run: return "supervisor_no_such_run";
    case ErrorCode::supervisor_service_lost: return "supervisor_service_lost";
    case ErrorCode::sim_scene_bad: return "sim_scene_bad";
    case ErrorCode::sim_render_failed: return "sim_render_failed";
  }
  return "unknown";
}

void throw_error(ErrorCode code, const std::string& message) { throw Error(code, message); }

void broken_invariant(const char* expression, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: broken invariant: %s\n", file, line, expression);
  std::abort();
}

}  // namespace periplus
