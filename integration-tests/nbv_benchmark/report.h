// The result as files: JSON with everything, CSV with a line a view.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "integration-tests/nbv_benchmark/benchmark.h"

namespace periplus::nbv_benchmark {

// Where and by what the result was made.
struct Provenance {
  std::string version, commit, date, machine, compiler, libraries, simd, command;
};
// Of this process; the commit is $PERIPLUS_COMMIT, "unknown" without it.
Provenance provenance(const std::string& command);

// Keys: `made` (provenance), `parameters`, `settings` (for each its objects, their runs, and `summary` by planner). Shares are
// 0..1, lengths in metres, poses three rows of X_OC. Times stand under `seconds` alone: without these and `made` the text is the
// same for the same parameters and seed.
nlohmann::json to_json(const BenchmarkResult& result, const BenchmarkOptions& options, const Provenance& made);

// Removes every `seconds` and `made`.
void without_times(nlohmann::json& report);

// One line a view: setting, object, planner, view, coverages, unknown voxels, travel, position and times.
std::string to_csv(const BenchmarkResult& result);

}  // namespace periplus::nbv_benchmark
