// The planner's parameters as its YAML gives them (config/default.yaml documents each).
#pragma once

#include <memory>
#include <string>

#include "common/core/config.h"
#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/situation.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv {

struct Settings {
  SearchSettings search;
  EvaluationSettings evaluation;
  ConstraintSettings constraints;
  std::shared_ptr<const Reachability> reachability;  // for every request; null: every pose is as good as another
  double revision_wait_s = 2;  // for a revision of the object that has not arrived
  int other_instances = 8;     // may share a request's tasks, at most
  // SHA-256 of the program's version and of all that a view depends on: planners that agree in it compute the same.
  std::string alike;
};

// Throws Error(bad_input) naming file, line and key.
Settings read_settings(const config::Node& root);

}  // namespace periplus::nbv
