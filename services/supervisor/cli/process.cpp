#include "services/supervisor/cli/process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/core/error.h"

extern char** environ;

namespace periplus::supervisor::cli {

using namespace std::chrono_literals;

namespace {

std::vector<std::string> environment_with(const std::map<std::string, std::string>& over) {
  std::vector<std::string> all;
  for (char** e = environ; *e; ++e) {
    const std::string text = *e;
    if (!over.contains(text.substr(0, text.find('=')))) all.push_back(text);
  }
  for (const auto& [name, value] : over) all.push_back(name + "=" + value);
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

}  // namespace

Process::Process(const ProcessOptions& options) {
  // Everything that allocates happens before fork(): the parent has threads whose locks the child would inherit.
  std::vector<std::string> arguments = options.arguments;
  arguments.insert(arguments.begin(), options.program.string());
  std::vector<std::string> environment = environment_with(options.environment);
  const std::vector<char*> argv = pointers(arguments), envp = pointers(environment);
  const std::string output = options.output.string();
  std::array<int, 2> report{};  // the child writes errno here if exec fails; closed by a successful one
  if (::pipe2(report.data(), O_CLOEXEC) != 0) throw Error(ErrorCode::io, std::string("cannot make a pipe: ") + std::strerror(errno));
  const pid_t parent = ::getpid();

  const pid_t child = ::fork();
  if (child == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);  // died in between
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::signal(SIGINT, SIG_DFL);
    ::signal(SIGPIPE, SIG_DFL);
    const int nothing = ::open("/dev/null", O_RDONLY);
    if (nothing >= 0) ::dup2(nothing, 0);
    if (!output.empty()) {
      const int file = ::open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
      if (file >= 0) {
        ::dup2(file, 1);
        ::dup2(file, 2);
      }
    }
    ::execve(argv[0], argv.data(), envp.data());
    const int problem = errno;
    const ssize_t written = ::write(report[1], &problem, sizeof problem);
    ::_exit(written > 0 ? 127 : 126);
  }
  ::close(report[1]);
  int problem = child < 0 ? errno : 0;
  if (child > 0) {
    while (::read(report[0], &problem, sizeof problem) < 0 && errno == EINTR) {
    }
    if (problem != 0) ::waitpid(child, nullptr, 0);
  }
  ::close(report[0]);
  if (problem != 0)
    throw Error(ErrorCode::io, "cannot start " + options.program.string() + ": " + std::strerror(problem) + "; build or install it");
  pid_ = child;
}

Process::~Process() { kill(); }

Process::Process(Process&& other) noexcept : pid_(other.pid_), status_(other.status_), reaped_(other.reaped_) { other.pid_ = -1; }

std::optional<int> Process::poll() {
  if (pid_ < 0 || status_) return status_;
  // Left unreaped: its number, which is its group's too, stays its own until kill().
  siginfo_t info{};
  if (::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0) {
    if (errno == ECHILD) status_ = 128;
  } else if (info.si_pid == pid_) {
    status_ = info.si_code == CLD_EXITED ? info.si_status : 128 + info.si_status;
  }
  return status_;
}

std::optional<int> Process::wait(std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (!poll() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(10ms);
  return poll();
}

void Process::terminate() {
  if (pid_ > 0 && !poll()) ::kill(pid_, SIGTERM);
}

void Process::kill() {
  if (pid_ <= 0 || reaped_) return;
  ::kill(-pid_, SIGKILL);
  while (!poll()) std::this_thread::sleep_for(2ms);
  ::waitpid(pid_, nullptr, 0);
  reaped_ = true;
}

std::optional<std::string> output_of(const std::filesystem::path& program, const std::vector<std::string>& arguments) {
  std::array<char, 32> name{"/tmp/periplus-output-XXXXXX"};
  const int file = ::mkstemp(name.data());
  if (file < 0) return std::nullopt;
  ::close(file);
  std::optional<std::string> text;
  try {
    Process process({.program = program, .arguments = arguments, .environment = {}, .output = name.data()});
    if (process.wait(20s) == 0) {
      std::ifstream in(name.data());
      std::ostringstream all;
      all << in.rdbuf();
      text = all.str();
    }
  } catch (const Error&) {
    // not there: the caller's answer is "nothing"
  }
  ::unlink(name.data());
  return text;
}

std::optional<unsigned long long> start_ticks(pid_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  if (!std::getline(in, text)) return std::nullopt;
  const std::size_t name_end = text.rfind(')');  // the name may hold anything, spaces and brackets included
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream rest(text.substr(name_end + 1));
  std::string field;
  for (int i = 3; i <= 22; ++i) {
    if (!(rest >> field)) return std::nullopt;
    if (i == 3 && field == "Z") return std::nullopt;
  }
  return std::stoull(field);
}

}  // namespace periplus::supervisor::cli
