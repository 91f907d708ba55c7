// A child process that cannot outlive its parent: own process group, killed when the thread that started it dies. One that
// ended stays a zombie until kill() or the destructor, so that no other process can bear its number meanwhile.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace periplus::supervisor::cli {

struct ProcessOptions {
  std::filesystem::path program;
  std::vector<std::string> arguments;               // without the program's name
  std::map<std::string, std::string> environment;   // laid over the parent's
  std::filesystem::path output;                     // standard output and error are appended here; empty: as the parent's
};

class Process {
 public:
  // Throws Error(io) if the program cannot be started (absent, not executable).
  explicit Process(const ProcessOptions& options);
  ~Process();  // kill()
  Process(Process&&) noexcept;
  Process& operator=(Process&&) = delete;

  pid_t pid() const { return pid_; }
  // Exit status, or 128 + the signal that ended it; nothing while it runs.
  std::optional<int> poll();
  std::optional<int> wait(std::chrono::milliseconds timeout);
  void terminate();                                 // SIGTERM to the process
  void kill();                                      // SIGKILL to its whole group; returns when it is gone and reaped

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
  bool reaped_ = false;
};

// Runs a program to its end and returns what it wrote on standard output; nothing if it could not be started or failed.
std::optional<std::string> output_of(const std::filesystem::path& program, const std::vector<std::string>& arguments);

// Start time of a process in clock ticks since boot: with the pid it names a process for good. Nothing if there is none.
std::optional<unsigned long long> start_ticks(pid_t pid);

}  // namespace periplus::supervisor::cli
