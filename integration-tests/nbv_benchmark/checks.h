// Issue 4's criteria on a report (report.h): what must hold for the planner to be called good.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace periplus::nbv_benchmark {

struct Check {
  std::string name;         // as acceptance names its values: nbv.free.worst_of_visible
  std::string what;         // a sentence
  double value = 0;
  std::string comparison;   // ">=", ">", "<="
  double limit = 0;
  bool ok = false;
  bool known = true;        // false: the report does not hold what the criterion is about; then it is not ok either
  std::string detail;       // which object, which rival
};

// Over the settings with an ideal sensor, unless said:
//   bunny_all_6           free poses: share of all of the bunny's surface after 6 views               >= 0.99
//   mean_of_visible_10    mean over the objects of the share of the visible surface after 10 views     >= 0.985
//   worst_of_visible_10   the least of these                                                          >= 0.94
//   behind_oracle_90, 95  most views that ours needs beyond the oracle, over the objects where either gets there   <= 1
//   ahead_of_literature   mean AUC less the best gain's                                               > 0
//   stereo_behind_ideal   points of coverage of the visible surface that stereo is behind, mean       <= 3
// `ours` is judged, which chooses from the same poses as its rivals.
std::vector<Check> check_criteria(const nlohmann::json& report);
nlohmann::json to_json(const std::vector<Check>& checks);

}  // namespace periplus::nbv_benchmark
