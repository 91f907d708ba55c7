// A program of the system as a child process of a test.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace periplus::harness {

class Program {
 public:
  using Environment = std::map<std::string, std::string>;

  // Starts `path` with `arguments`; `environment` is added to ours; output goes to `log_file` (appended). Throws Error(io).
  Program(const std::string& path, const std::vector<std::string>& arguments, const Environment& environment,
          const std::string& log_file);
  // Asks it to stop; kills it after 5 s.
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t pid() const { return pid_; }
  void signal(int number);
  // Exit status, or 128 + signal; nothing if it still runs after `timeout`.
  std::optional<int> wait(std::chrono::milliseconds timeout);
  bool running() { return !wait(std::chrono::milliseconds(0)); }

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
};

}  // namespace periplus::harness
