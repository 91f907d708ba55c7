// The result as files: JSON with everything, CSV with a line a value, Markdown with tables and pictures.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "integration-tests/eyes_benchmark/benchmark.h"
#include "integration-tests/eyes_benchmark/checks.h"
#include "integration-tests/nbv_benchmark/report.h"

namespace periplus::eyes_benchmark {

// Keys: `made` (provenance), `parameters`, `stereo`, `carved`, `real`, `checks`. Shares 0..1, metres, radians. Times stand under
// `seconds` alone.
nlohmann::json to_json(const BenchmarkResult& result, const BenchmarkOptions& options, const std::vector<Check>& checks,
                       const nbv_benchmark::Provenance& made);
// table,object,texture,voxel_m,source,measure,value
std::string to_csv(const BenchmarkResult& result);
// `pictures`: link prefix of the pictures' folder, empty: without.
std::string to_markdown(const BenchmarkResult& result, const BenchmarkOptions& options, const std::vector<Check>& checks,
                        const nbv_benchmark::Provenance& made, const std::string& pictures);

}  // namespace periplus::eyes_benchmark
