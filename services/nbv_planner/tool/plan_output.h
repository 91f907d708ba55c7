// What `periplus nbv` prints.
#pragma once

#include <cstdint>
#include <string>

#include "services/nbv_planner/tool/plan_input.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv {

struct Planned {
  PlannedView view;
  std::string method;
  std::uint64_t seed = 0;
  double seconds = 0;          // of the whole search, wall clock
  voxel::Counts counts;        // of the model
  std::string no_view;         // why there is none; empty: there is one
};

std::string to_text(const PlanInput& input, const Planned& planned);
// One object, documented in README.md; the same with a view and without.
std::string to_json(const PlanInput& input, const Planned& planned);

}  // namespace periplus::nbv
