// `periplus run`, `up` and `down`.
#pragma once

#include <string>
#include <vector>

namespace periplus::supervisor::cli {

struct RunOptions {
  std::string task;
  std::vector<std::string> overrides;    // key=value, into the task
  std::string output;                    // instead of the task's
  bool check = false;                    // only read and check
  bool attach = false;                   // never start services; wait for those of the domain
};
// Takes the task from start to end. Returns the exit status of the run (supervisor/README.md).
int run_task(const RunOptions& options);

struct UpOptions {
  std::string task;                      // which robot and scene; empty: the demo's
  std::vector<std::string> overrides;
  std::string output;
  bool detach = false;
};
// Keeps the services running until a signal; with `detach` in the background, returning when all are ready.
int up(const UpOptions& options);
// Ends what `up` (or `run`) of this user keeps running on the domain.
int down();

}  // namespace periplus::supervisor::cli
