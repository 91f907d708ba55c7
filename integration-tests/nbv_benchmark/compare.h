// Planners beside each other over several reports (report.h), as of several seeds: what one run of ten objects cannot tell from chance.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace periplus::nbv_benchmark {

struct Compared {
  std::string setting, planner;
  int runs = 0;                    // objects x reports
  double auc = 0;                  // mean area under the coverage of the visible surface
  double ahead = 0, ahead_error = 0;  // of it, beyond the first planner of the setting on the same object and seed: mean and its standard error
  double views[3] = {};            // mean number of views to 90, 95, 99 % of the visible surface; not reached: one more than were made
  // Runs that need over a view more than the oracle to 90 and to 95 %; -1: there is no oracle.
  int behind_oracle[2] = {-1, -1};
  double last = 0;                 // mean coverage of the visible surface after the last view
  double error = 0;                // mean distance of the depth points to the true surface [m]
  double plan_seconds = 0;         // mean of a plan
};

// In the order of the first report. Reports need not hold the same objects, but each planner of a setting must have run on all of
// the setting's objects. Throws Error(bad_input) for reports of one seed and setting twice, or of different planners.
std::vector<Compared> compare(const std::vector<nlohmann::json>& reports);
// Markdown, one table a setting, with commit, machine and seeds.
std::string to_markdown(const std::vector<Compared>& rows, const std::vector<nlohmann::json>& reports);

}  // namespace periplus::nbv_benchmark
