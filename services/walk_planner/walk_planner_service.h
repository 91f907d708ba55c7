// The walk planner on the bus: RPC walk/plan. Keeps no state between requests.
#pragma once

#include <memory>

#include "common/core/config.h"
#include "common/service/service.h"
#include "services/walk_planner/walk_planner.h"

namespace periplus::walk {

// Reads every parameter of config/default.yaml. Throws Error(bad_input) that names file, line and key.
WalkSettings read_settings(const config::Node& configuration);

class WalkPlannerService {
 public:
  WalkPlannerService(service::Service& service, const WalkSettings& settings);
  ~WalkPlannerService();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::walk
