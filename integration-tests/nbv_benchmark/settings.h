// The benchmark's parameters as its YAML gives them (config/default.yaml documents each).
#pragma once

#include "common/core/config.h"
#include "integration-tests/nbv_benchmark/benchmark.h"

namespace periplus::nbv_benchmark {

// Everything but objects, robot, threads, folders and the planner's own settings. Throws Error(bad_input) naming file, line and
// key.
BenchmarkOptions read_options(const config::Node& root);

// Throws Error(bad_input) for another word.
PoseSet pose_set_of(const std::string& word);
SensorKind sensor_of(const std::string& word);
Camera camera_of(const std::string& word);

}  // namespace periplus::nbv_benchmark
