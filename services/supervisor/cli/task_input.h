// From the command line to what is sent: the task with its overrides, the texts of its environment, names of runs.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "services/supervisor/cli/client_service.h"
#include "services/supervisor/task.h"

namespace periplus::supervisor::cli {

// Reads the task and sets `overrides` ("stop.most_looks=6") in it; its output folder becomes absolute. `file` may also be
// the bare name of a task that came with the program ("bunny"). Throws Error(bad_input, io).
Task read_task(const std::string& file, const std::vector<std::string>& overrides, const std::string& output);

// Reads and checks scene, robot YAML and URDF (<robot>.urdf beside <robot>.yaml). The texts hold nothing of the scene's part
// `truth`. Throws Error(bad_input, io).
EnvironmentTexts read_environment(const Task& task);

// Looks up and loads the object's mesh where the scene's part `truth` names one: for the computer on which the simulator will
// run. Throws Error(io) with the folders searched or what is wrong with the file.
void check_true_object(const Task& task);

// "20260131-123456-bunny" (UTC).
std::string run_id_of(const std::string& task_name, std::chrono::system_clock::time_point now);

}  // namespace periplus::supervisor::cli
