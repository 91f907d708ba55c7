// The services that make up the system, in the order of their start. A task, the launcher and the tests speak of them by these names.
#pragma once

#include <string>
#include <vector>

namespace periplus::service {

inline const std::vector<std::string>& service_names() {
  static const std::vector<std::string> names = {"simulator",         "vision_server", "model_server",      "nbv_planner",
                                                 "posture_generator", "walk_planner",  "motion_controller", "supervisor"};
  return names;
}

}  // namespace periplus::service
