#include "integration-tests/harness/program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <thread>

#include "common/core/error.h"

namespace periplus::harness {

Program::Program(const std::string& path, const std::vector<std::string>& arguments, const Environment& environment,
                 const std::string& log_file) {
  std::vector<std::string> words{path}, settings;
  words.insert(words.end(), arguments.begin(), arguments.end());
  for (char** e = environ; *e; ++e) {
    const std::string entry(*e);
    if (!environment.contains(entry.substr(0, entry.find('=')))) settings.push_back(entry);
  }
  for (const auto& [key, value] : environment) settings.push_back(key + "=" + value);
  const auto pointers = [](std::vector<std::string>& texts) {
    std::vector<char*> out;
    for (std::string& text : texts) out.push_back(text.data());
    out.push_back(nullptr);
    return out;
  };
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log_file.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  const int failed =
      posix_spawn(&pid_, path.c_str(), &files, nullptr, pointers(words).data(), pointers(settings).data());
  posix_spawn_file_actions_destroy(&files);
  require(failed == 0, ErrorCode::io, "cannot start " + path + ": " + std::strerror(failed));
}

Program::~Program() {
  if (!running()) return;
  signal(SIGTERM);
  if (wait(std::chrono::seconds(5))) return;
  signal(SIGKILL);
  wait(std::chrono::seconds(5));
}

void Program::signal(int number) {
  if (running()) ::kill(pid_, number);
}

std::optional<int> Program::wait(std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (!status_) {
    int raw = 0;
    if (::waitpid(pid_, &raw, WNOHANG) == pid_)
      status_ = WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
    else if (std::chrono::steady_clock::now() >= end)
      return std::nullopt;
    else
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return status_;
}

}  // namespace periplus::harness
