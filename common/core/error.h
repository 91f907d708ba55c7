// Errors of Periplus. Inside a process they are exceptions; at its border they become a reply's `error_code` and a
// sentence that a person can act on.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace periplus {

// Number ranges: 1-99 common, 100 vision, 200 model, 300 nbv, 400 posture, 500 walk, 600 motion, 700 supervisor,
// 800 robot drivers and simulator. Each service lists its own in its README.
enum class ErrorCode : std::int32_t {
  ok = 0,
  internal = 1,            // a defect of ours
  bad_input = 2,           // a file, a parameter or a request that cannot be used; the message says what to do
  bad_size = 3,            // an array whose length does not fit
  not_finite = 4,          // NaN or infinity where a number is needed
  unknown_id = 5,          // nothing goes by that name here
  cancelled = 6,
  not_ready = 7,
  io = 8,                  // a file could not be read or written
  vision_images_missing = 101,     // the cameras did not deliver a complete set
  vision_image_bad = 102,          // truncated, wrong size, encoding or stamp
  vision_view_unknown = 103,
  vision_no_depth = 104,           // a blank or unmatched eye: too few valid pixels
  vision_revision_not_here = 105,
  model_object_unknown = 201,
  model_perception_not_here = 202, // asked for a view whose perception has not arrived
  model_environment_missing = 203,
  model_store = 204,
  model_object_differs = 205,      // begun before with another box or voxel size
  nbv_no_reachable_view = 301,
  nbv_revision_not_here = 302,
  posture_infeasible = 401,
  posture_revision_not_here = 402,
  walk_no_path = 501,
  walk_revision_not_here = 502,
  walk_start_in_collision = 503,
  walk_goal_in_collision = 504,
  motion_robot_fault = 601,
  motion_halted = 602,
  motion_robot_silent = 603,
  motion_joint_limit = 604,
  motion_busy = 605,
  motion_revision_not_here = 606,
  supervisor_busy = 701,
  supervisor_bad_task = 702,
  supervisor_no_such_run = 703,
  supervisor_service_lost = 704,
  sim_scene_bad = 801,
  sim_render_failed = 802,
};

// The code's name as documented, for example "nbv_no_reachable_view".
const char* to_string(ErrorCode code);

// Thrown for everything that a caller, a file or a peer did wrong, and for what the machine refused.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

[[noreturn]] void throw_error(ErrorCode code, const std::string& message);

// A caller's error: throws Error(code, message) unless `condition` holds.
inline void require(bool condition, ErrorCode code, const char* message) {
  if (!condition) throw_error(code, message);
}
inline void require(bool condition, ErrorCode code, const std::string& message) {
  if (!condition) throw_error(code, message);
}

// Our own error: prints where and aborts.
[[noreturn]] void broken_invariant(const char* expression, const char* file, int line);
#define PERIPLUS_ASSERT(condition) ((condition) ? void(0) : ::periplus::broken_invariant(#condition, __FILE__, __LINE__))

}  // namespace periplus
