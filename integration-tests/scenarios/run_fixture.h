// A whole run of the system as a test sees it: `periplus run TASK` in a DDS domain and a folder of its own, with all that it
// left behind. What happens meanwhile is read from the run's whiteboard, so a test can strike at a given state.
//
//   SystemRun run({.task = "bunny-short", .changes = {"dds.simulator=cyclonedds"}});
//   ASSERT_TRUE(run.wait_for_state("process_images", 2));
//   run.kill_service("vision_server");
//   const RunResult result = run.finish();
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/dds/testing/test_domain.h"
#include "integration-tests/harness/program.h"

namespace periplus::scenarios {

struct RunRequest {
  std::string task = "bunny-short";               // of deploy/tasks, or a path
  std::vector<std::string> changes = {};          // "voxel_m=0.02", "dds.simulator=cyclonedds", "scene=/a/path.yaml"
  std::map<std::string, std::string> environment = {};   // of the launcher and, through it, of every service
  std::vector<std::string> arguments = {};        // more of `periplus run`
};

struct StateEntered {
  std::string state, cause;
  int look = 0;
  std::int64_t wall_time_ns = 0;
};

struct RunResult {
  std::optional<int> status;        // nothing: it hung, and was ended by the test
  std::string output;               // what the terminal showed
  std::filesystem::path folder;     // of this run; empty if none was made
  nlohmann::json report;            // report.json; null if there is none
  // SHA-256 of each file of the run that one seed must repeat to the bit, by its name below the folder: the model in all its
  // formats, the depth of the looks. `model.periplus` without what carries the run's name, its views' ids and its checksum.
  std::map<std::string, std::string> hashes;
  std::vector<StateEntered> states;
  std::optional<double> seconds_after_kill;   // from the last kill_service() to the end of the command

  std::vector<std::string> state_names() const;
  // Whether `to` was entered straight after `from`, and with `cause` if given (part of the text).
  bool went(const std::string& from, const std::string& to, const std::string& cause = "") const;
};

class SystemRun {
 public:
  using Milliseconds = std::chrono::milliseconds;

  explicit SystemRun(const RunRequest& request);
  // Ends what still runs. The folder stays if the test failed, so that it can be looked at.
  ~SystemRun();
  SystemRun(const SystemRun&) = delete;
  SystemRun& operator=(const SystemRun&) = delete;

  int domain() const { return domain_.id(); }
  // Of this test: the run folder is made below it.
  const std::filesystem::path& output_folder() const { return output_; }
  // Run folder; empty before there is one.
  std::filesystem::path folder() const;
  std::vector<StateEntered> states() const;
  std::string output() const;

  // True once the run stands in `state` at look `look` or later (0: any); false if the run ends or `timeout` passes before.
  bool wait_for_state(const std::string& state, int look = 0, Milliseconds timeout = std::chrono::seconds(120));
  // Program of `service` ("vision_server") that this run started; 0 if it is not there.
  pid_t pid_of(const std::string& service) const;
  // Every process that this run started and that has not ended, directly or not: those in whose environment its own
  // XDG_RUNTIME_DIR stands.
  std::vector<pid_t> processes() const;
  // SIGKILL by default; false if the program is not there.
  bool kill_service(const std::string& service, int signal = 9);
  void interrupt();   // Ctrl-C

  RunResult finish(Milliseconds timeout = std::chrono::seconds(200));

 private:
  dds::testing::TestDomain domain_;
  std::filesystem::path output_, log_;
  std::unique_ptr<harness::Program> program_;
  std::optional<std::chrono::steady_clock::time_point> killed_;
};

// Shared memory files of Fast DDS that no process has open or mapped (what is left after a kill), without those in `before`.
// Ports carry their number in the name: those of other domains than `domain` are left out (-1: none is).
std::vector<std::string> shared_memory_left(int domain = -1, const std::vector<std::string>& before = {});

}  // namespace periplus::scenarios
