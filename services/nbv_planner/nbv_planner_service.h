// RPC nbv/plan: the only file of the planner that knows DDS and wire types. Stateless between requests.
#pragma once

#include <memory>

#include "common/service/service.h"
#include "services/nbv_planner/settings.h"

namespace periplus::nbv {

class NbvPlannerService {
 public:
  // Serves from here on.
  NbvPlannerService(service::Service& service, const Settings& settings);
  ~NbvPlannerService();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::nbv
