// Keeps the programs of a system running: starts them, restarts those that keep no state, tells when one is lost for good,
// and leaves nothing behind. Knows no DDS: who is ready is the caller's to find out (by heartbeats).
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/service/service_names.h"
#include "services/supervisor/task.h"

namespace periplus::supervisor::cli {

using service::service_names;

struct Program {
  std::string service;                              // "vision_server"
  std::string name = service;                       // of this instance, "nbv_planner-2": names its files
  std::filesystem::path path;
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment;
  bool restarts = false;                            // may be started again after a crash
};

// "vision_server" -> "periplus-vision-server".
std::string program_name(const std::string& service);
// Services that do not hold the run's state, or hold it on disk: restarted after a crash.
bool restarts(const std::string& service);

// Programs of a task: those beside the running executable (`folder`), their vendor as the task says, logs into `logs`.
std::vector<Program> programs_of(const Task& task, const std::filesystem::path& folder, const std::filesystem::path& logs);

class Launcher {
 public:
  struct Event {
    enum class Kind { restarted, fewer, lost } kind;  // fewer: an instance will not come back, but others of its service go on
    std::string service;
    std::string text;                               // for a person
    bool refused = false;                           // it ended by itself with status 2: its input is to be corrected
  };

  // `logs` is created; each program's own output is appended to <logs>/<name>.out.
  Launcher(std::vector<Program> programs, std::filesystem::path logs, int most_restarts = 3);
  ~Launcher();  // stop()
  Launcher(const Launcher&) = delete;
  Launcher& operator=(const Launcher&) = delete;

  // Throws Error(io) if a program is missing; what was started is stopped again.
  void start();
  // To be called often: looks after the programs and tells what happened since.
  std::vector<Event> supervise();
  // Processes by name, those alive.
  std::map<std::string, int> pids() const;
  // Asks all to end, kills who has not ended after `grace`, removes what they left in shared memory. May be called again.
  void stop(std::chrono::milliseconds grace = std::chrono::seconds(5));

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::supervisor::cli
