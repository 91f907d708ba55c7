#include "services/supervisor/cli/run_command.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <thread>

#include "common/core/clock.h"
#include "common/core/error.h"
#include "common/dds/node.h"
#include "common/core/locate.h"
#include "services/supervisor/cli/background.h"
#include "services/supervisor/cli/process.h"
#include "services/supervisor/cli/session.h"
#include "services/supervisor/cli/task_input.h"

namespace periplus::supervisor::cli {
namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

constexpr int kServiceLost = 5, kAborted = 130;
constexpr auto kAfterLoss = 3s;      // for the supervisor to write its report once it was told of a lost service
constexpr auto kAfterAbort = 20s;    // for the robot to come to a stand
constexpr auto kAfterSupervisor = 1s;

// The terminal's last line shows what is under way; everything else scrolls above it.
class Terminal {
 public:
  void print(const std::string& text) {
    if (text.empty()) return;
    erase();
    std::cout << text << std::flush;
  }
  void show(const std::string& line) {
    if (!is_terminal_ || line == shown_) return;
    erase();
    std::cout << line << std::flush;
    shown_ = line;
  }
  void erase() {
    if (!shown_.empty()) std::cout << "\r\x1b[K";
    shown_.clear();
  }

 private:
  const bool is_terminal_ = ::isatty(STDOUT_FILENO) == 1;
  std::string shown_;
};

// Follows the run to its end; the exit status.
int follow(Session& session, const std::string& run_id) {
  Terminal terminal;
  RunView view;
  terminal.print(RunView::header());
  std::optional<Clock::time_point> give_up;
  bool aborting = false, lost = false;
  while (true) {
    for (const RunEvent& event : session.client().take_events()) {
      if (event.run_id != run_id) continue;
      terminal.print(view.add(event));
      // What a lost service leads to depends on who was using it; the loss is what the caller must know.
      if (event.kind == "end") return lost && event.exit_status != 0 && !aborting ? kServiceLost : event.exit_status;
    }
    const Session::Looked looked = session.look_after();
    for (const std::string& news : looked.news) terminal.print("      " + news + "\n");
    if (!looked.lost.empty() && !lost) {
      lost = true;
      const bool nobody_decides = std::find(looked.lost.begin(), looked.lost.end(), "supervisor") != looked.lost.end();
      if (!nobody_decides) session.client().report_loss(run_id, looked.news.empty() ? looked.lost.front() + " is gone" : looked.news.back());
      give_up = Clock::now() + (nobody_decides ? std::chrono::milliseconds(kAfterSupervisor) : std::chrono::milliseconds(kAfterLoss));
    }
    if (Interrupts::count() > 0 && !aborting) {
      aborting = true;
      terminal.print("      aborting; the robot comes to a stand (again Ctrl-C: at once)\n");
      give_up = Clock::now() + kAfterAbort;
      try {
        session.client().abort(run_id);
      } catch (const Error& e) {
        terminal.print(std::string("      ") + e.what() + "\n");
        return kAborted;
      }
    }
    if (Interrupts::count() > 1) return kAborted;
    if (give_up && Clock::now() > *give_up) return aborting ? kAborted : kServiceLost;
    terminal.show(view.under_way(wall_time_ns()));
    std::this_thread::sleep_for(50ms);
  }
}

// Runs a program that stands beside this one, if it does.
void run_beside(const std::string& name, const std::string& argument) {
  const fs::path program = executable_folder() / name;
  if (!fs::exists(program)) return;
  try {
    Process process({.program = program, .arguments = {argument}, .environment = {}, .output = {}});
    while (!process.wait(100ms) && Interrupts::count() < 2) {
    }
    const int status = process.poll().value_or(kAborted);
    if (status != 0) std::cerr << name << " ended with status " << status << "\n";
  } catch (const Error& e) {  // the run's own exit status stands, whatever becomes of its evaluation
    std::cerr << e.what() << "\n";
  }
}

// The client speaks the vendor of the supervisor unless the environment says otherwise; vendors understand each other.
void choose_vendor(const Task& task) {
  if (const std::string vendor = task.vendor("supervisor"); !vendor.empty()) ::setenv("PERIPLUS_DDS", vendor.c_str(), 0);
}

}  // namespace

int run_task(const RunOptions& options) {
  const Task task = read_task(options.task, options.overrides, options.output);
  const EnvironmentTexts environment = read_environment(task);
  if (options.check) {
    check_true_object(task);
    std::cout << options.task << ": task, scene, robot and the object's mesh are good\n";
    return 0;
  }
  choose_vendor(task);
  const Interrupts interrupts;
  const std::string run_id = run_id_of(task.name, std::chrono::system_clock::now());
  int status = 0;
  std::string run_folder;
  {
    Session session;
    if (!options.attach && !session.occupied()) {
      check_true_object(task);
      session.start(task, fs::path(task.output) / run_id / "logs");
      std::cout << "starting the services on domain " << session.client().domain() << std::endl;
    } else {
      std::cout << "using the services on domain " << session.client().domain() << std::endl;
    }
    try {
      session.wait_until_ready();
    } catch (const Error& e) {
      if (e.code() != ErrorCode::cancelled) throw;
      return kAborted;
    }
    run_folder = session.client().start(run_id, task.yaml(), environment);
    std::cout << "run " << run_id << ": object " << task.object_id << ", voxels of " << 1000 * task.voxel_m << " mm, at most " << task.stop.most_looks << " looks\n";
    status = follow(session, run_id);
    session.stop(status == kServiceLost ? 2s : 5s);
  }
  // Evaluated here, after the robot's software has ended: it shares nothing with it.
  if (fs::exists(fs::path(run_folder) / "report.json")) {
    // A run that was cut short by a loss has no model to judge, and its caller is not to wait for that.
    if (fs::exists(fs::path(run_folder) / "truth.json") && fs::exists(fs::path(run_folder) / "model.ply")) run_beside("periplus-evaluate", run_folder);
    run_beside("periplus-report", run_folder);
  }
  std::cout << "exit status " << status << " (" << meaning_of(status) << "); everything stands in " << run_folder << std::endl;
  return status;
}

namespace {

// `tell` gets what the person at the terminal should read; `ready` is called once.
int keep_up(const Task& task, const fs::path& logs, const std::function<void(const std::string&)>& tell, const std::function<void()>& ready) {
  const Interrupts interrupts;
  Session session;
  if (session.occupied()) {
    const bool is_ours = find_background(session.client().domain()).has_value();
    if (is_ours) session.wait_until_ready();
    tell(service_table(session.client().services()));
    if (!awaited(session.client().services()).empty()) throw Error(ErrorCode::bad_input, "domain " + std::to_string(session.client().domain()) + " is in use by others; stop them or set PERIPLUS_DOMAIN");
    tell("all services are up already\n");
    return 0;
  }
  check_true_object(task);
  session.start(task, logs);
  session.wait_until_ready();
  tell(service_table(session.client().services()));
  tell("ready on domain " + std::to_string(session.client().domain()) + "; logs in " + logs.string() + "\n");
  ready();
  while (Interrupts::count() == 0) {
    const Session::Looked looked = session.look_after();
    for (const std::string& news : looked.news) tell(news + "\n");
    if (!looked.lost.empty()) return kServiceLost;
    std::this_thread::sleep_for(100ms);
  }
  return 0;
}

int status_of(const Error& e) {
  std::cerr << "periplus: " << e.what() << std::endl;
  return e.code() == ErrorCode::supervisor_service_lost ? kServiceLost : e.code() == ErrorCode::cancelled ? kAborted : 2;
}

// The child goes on as keeper; the parent returns with what the keeper said until it was ready or gave up.
int detached(const std::function<int(const std::function<void(const std::string&)>&, const std::function<void()>&)>& keep, const fs::path& logs) {
  std::array<int, 2> channel{};
  if (::pipe2(channel.data(), O_CLOEXEC) != 0) throw Error(ErrorCode::io, "cannot make a pipe");
  std::cout << std::flush;
  const pid_t child = ::fork();  // before this process joins the bus: there are no threads yet
  if (child < 0) throw Error(ErrorCode::io, "cannot start a background process");
  if (child == 0) {
    ::close(channel[0]);
    ::setsid();
    const int nothing = ::open("/dev/null", O_RDONLY);
    const int file = ::open((logs / "launcher.out").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
    ::dup2(nothing, 0);
    ::dup2(file, 1);
    ::dup2(file, 2);
    const auto send = [&channel](const std::string& text) {
      if (channel[1] < 0 || ::write(channel[1], text.data(), text.size()) < 0) std::cout << text << std::flush;
    };
    int status = 1;
    try {
      status = keep(send, [&channel] {
        const char code = 0;
        if (::write(channel[1], &code, 1) == 1) ::close(channel[1]);
        channel[1] = -1;
      });
    } catch (const Error& e) {
      send(std::string("periplus: ") + e.what() + "\n");
      status = status_of(e);
    }
    if (channel[1] >= 0) {  // never got ready: the byte after the text is the exit status
      const std::array<char, 2> code{'\0', static_cast<char>(status)};
      if (::write(channel[1], code.data(), code.size()) < 0) std::cerr << "the caller is gone\n";
    }
    ::_exit(status);
  }
  ::close(channel[1]);
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t n; (n = ::read(channel[0], buffer.data(), buffer.size())) > 0;) text.append(buffer.data(), static_cast<std::size_t>(n));
  ::close(channel[0]);
  const std::size_t end = text.find('\0');
  std::cout << text.substr(0, end) << std::flush;
  if (end == std::string::npos) throw Error(ErrorCode::internal, "the background process ended early; see " + (logs / "launcher.out").string());
  return end + 1 < text.size() ? static_cast<unsigned char>(text[end + 1]) : 0;
}

}  // namespace

int up(const UpOptions& options) {
  const Task task = read_task(options.task.empty() ? "bunny" : options.task, options.overrides, options.output);
  read_environment(task);  // refuses here what the services would refuse one by one
  choose_vendor(task);
  const fs::path logs = fs::path(task.output) / run_id_of("up", std::chrono::system_clock::now()) / "logs";
  fs::create_directories(logs);
  if (!options.detach) return keep_up(task, logs, [](const std::string& text) { std::cout << text << std::flush; }, [] {});
  return detached([&](const auto& tell, const auto& ready) { return keep_up(task, logs, tell, ready); }, logs);
}

int down() {
  const int domain = dds::NodeOptions::from_environment("periplus").domain;
  const auto keeper = find_background(domain);
  if (!keeper) {
    std::cout << "nothing of this user is kept up on domain " << domain << "; `periplus status` shows who else is there\n";
    return 0;
  }
  ::kill(keeper->pid, SIGTERM);
  const auto end = Clock::now() + 40s;
  while (find_background(domain)) {
    if (Clock::now() > end) throw Error(ErrorCode::internal, "process " + std::to_string(keeper->pid) + " does not end; kill it");
    std::this_thread::sleep_for(50ms);
  }
  std::cout << "stopped; logs in " << keeper->logs << "\n";
  return 0;
}

}  // namespace periplus::supervisor::cli
