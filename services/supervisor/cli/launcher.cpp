#include "services/supervisor/cli/launcher.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>

#include "common/core/error.h"
#include "services/supervisor/cli/process.h"
#include "services/supervisor/cli/shared_memory.h"

namespace periplus::supervisor::cli {
namespace fs = std::filesystem;

std::string program_name(const std::string& service) {
  std::string name = "periplus-" + service;
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

bool restarts(const std::string& service) { return service != "simulator" && service != "motion_controller" && service != "supervisor"; }

std::vector<Program> programs_of(const Task& task, const fs::path& folder, const fs::path& logs) {
  std::vector<Program> programs;
  const auto add = [&](const std::string& service, const std::string& name) {
    Program program{.service = service,
                    .name = name,
                    .path = folder / program_name(service),
                    .arguments = {"--log-file", (logs / (name + ".jsonl")).string()},
                    // The services share the cores, and results must not depend on how many there are.
                    .environment = {{"OPENBLAS_NUM_THREADS", "1"}, {"OMP_NUM_THREADS", "1"}, {"LP_NUM_THREADS", "1"}},
                    .restarts = restarts(service)};
    if (const std::string vendor = task.vendor(service); !vendor.empty()) program.environment["PERIPLUS_DDS"] = vendor;
    if (service == "simulator") {
      program.arguments.insert(program.arguments.end(), {"--scene", task.scene, "--robot", task.robot});
      if (task.truth) program.arguments.emplace_back("--truth");
    }
    // The run's own store: a restarted model server finds its object there, and no other run's.
    if (service == "model_server")
      program.arguments.insert(program.arguments.end(), {"--set", "store_folder=\"" + (logs.parent_path() / "knowledge").string() + "\""});
    programs.push_back(std::move(program));
  };
  for (const std::string& service : service_names()) {
    add(service, service);
    for (int i = 2; i <= task.instances_of(service); ++i) add(service, service + "-" + std::to_string(i));
  }
  return programs;
}

namespace {
// The last line that is not empty; nothing if there is none.
std::string last_line(const fs::path& file) {
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) last = line;
  return last.substr(0, 1000);
}
}  // namespace

struct Launcher::Impl {
  struct Child {
    Program program;
    std::optional<Process> process;
    int restarts = 0;
    bool lost = false;
  };

  void start(Child& child) {
    child.process.reset();
    child.process.emplace(ProcessOptions{.program = child.program.path,
                                         .arguments = child.program.arguments,
                                         .environment = child.program.environment,
                                         .output = logs / (child.program.name + ".out")});
  }
  Event::Kind kind_of_loss(const Child& child) const {
    const bool others = std::any_of(children.begin(), children.end(), [&](const Child& c) { return c.program.service == child.program.service && !c.lost; });
    return others ? Event::Kind::fewer : Event::Kind::lost;
  }

  std::vector<Child> children;
  fs::path logs;
  int most_restarts = 3;
};

Launcher::Launcher(std::vector<Program> programs, fs::path logs, int most_restarts) : impl_(std::make_unique<Impl>()) {
  std::error_code problem;
  fs::create_directories(logs, problem);
  require(!problem, ErrorCode::io, "cannot create the folder " + logs.string() + ": " + problem.message() + "; choose another with --output");
  impl_->logs = std::move(logs);
  impl_->most_restarts = most_restarts;
  for (Program& program : programs) {
    impl_->children.emplace_back();
    impl_->children.back().program = std::move(program);
  }
}

Launcher::~Launcher() { stop(); }

void Launcher::start() {
  try {
    for (Impl::Child& child : impl_->children) impl_->start(child);
  } catch (const Error&) {
    stop();
    throw;
  }
}

std::vector<Launcher::Event> Launcher::supervise() {
  std::vector<Event> events;
  for (Impl::Child& child : impl_->children) {
    if (child.lost || !child.process) continue;
    const std::optional<int> status = child.process->poll();
    if (!status) continue;
    const std::string how = *status > 128 ? "was ended by signal " + std::to_string(*status - 128) : "ended with status " + std::to_string(*status);
    const std::string& service = child.program.service;
    const std::string& name = child.program.name;
    if (*status == 2) {  // it refused its configuration: it would do so again
      child.lost = true;
      const std::string reason = last_line(impl_->logs / (name + ".out"));
      events.push_back({.kind = Event::Kind::lost,
                        .service = service,
                        .text = reason.empty() ? name + " refused to start and gave no reason; see " + (impl_->logs / (name + ".jsonl")).string()
                                               : name + " refused to start: " + reason,
                        .refused = true});
    } else if (!child.program.restarts || child.restarts >= impl_->most_restarts) {
      child.lost = true;
      const std::string why = child.program.restarts ? " after " + std::to_string(child.restarts) + " restarts" : "";
      events.push_back({impl_->kind_of_loss(child), service, name + " " + how + why + "; see " + (impl_->logs / (name + ".jsonl")).string()});
    } else {
      ++child.restarts;
      try {
        impl_->start(child);
        events.push_back({Event::Kind::restarted, service,
                          name + " " + how + "; restarted (" + std::to_string(child.restarts) + " of " + std::to_string(impl_->most_restarts) + ")"});
      } catch (const Error& e) {
        child.lost = true;
        events.push_back({impl_->kind_of_loss(child), service, name + " " + how + " and did not start again: " + e.what()});
      }
    }
  }
  return events;
}

std::map<std::string, int> Launcher::pids() const {
  std::map<std::string, int> all;
  for (Impl::Child& child : impl_->children)
    if (child.process && !child.process->poll()) all[child.program.name] = child.process->pid();
  return all;
}

void Launcher::stop(std::chrono::milliseconds grace) {
  bool any = false;
  const auto end = std::chrono::steady_clock::now() + grace;
  for (Impl::Child& child : impl_->children)
    if (child.process) child.process->terminate();
  for (Impl::Child& child : impl_->children) {
    if (!child.process) continue;
    any = true;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    child.process->wait(std::max(left, std::chrono::milliseconds(0)));
    child.process.reset();
  }
  if (any) clean_shared_memory();
}

}  // namespace periplus::supervisor::cli
