// RPC nbv/tasks: parts of a search done for other instances of the planner, and by them (scattered_runner.h).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/service/service.h"
#include "idl/nbv.h"
#include "services/nbv_planner/scattered_runner.h"

namespace periplus::nbv {

class TaskExchange {
 public:
  // The search of a request; throws Error(nbv_revision_not_here) where it cannot be made here.
  using SearchOf = std::function<std::function<void(TaskRunner&)>(const msg::PlanViewRequest&)>;

  // Serves from here on. `alike`: what instances must have in common to compute the same; `threads` for a part.
  TaskExchange(service::Service& service, const std::string& alike, int threads, SearchOf search_of);
  ~TaskExchange();

  // At most `most` of the other live instances, for a search of `request`.
  std::vector<std::unique_ptr<OtherInstance>> others(const msg::PlanViewRequest& request, int most);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::nbv
