#include "integration-tests/scenarios/run_fixture.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

#include "common/core/hash.h"

namespace periplus::scenarios {
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

namespace {

std::string read_text(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

bool is_process(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// Parent of a process; 0 if it is gone. The name in parentheses may hold anything, so the last one counts.
pid_t parent_of(const fs::path& process) {
  const std::string stat = read_text(process / "stat");
  const std::size_t at = stat.rfind(')');
  if (at == std::string::npos) return 0;
  std::istringstream rest(stat.substr(at + 1));
  char state = 0;
  pid_t parent = 0;
  rest >> state >> parent;
  return state == 'Z' ? 0 : parent;
}

fs::path task_file(const std::string& task) {
  if (task.find('/') != std::string::npos) return task;
  return fs::path(PERIPLUS_SOURCE_DIR) / "deploy/tasks" / (task + ".yaml");
}

// Ports are numbered as RTPS numbers them over UDP: 7400 + 250 domain and up.
bool is_port_of_another(const std::string& name, int domain) {
  const std::size_t at = name.find("fastrtps_port");
  if (at == std::string::npos || domain < 0) return false;
  const int first = 7400 + 250 * domain, port = std::atoi(name.c_str() + at + std::string("fastrtps_port").size());
  return port < first || port >= first + 250;
}

std::vector<StateEntered> read_states(const fs::path& whiteboard) {
  std::vector<StateEntered> states;
  std::ifstream file(whiteboard);
  for (std::string line; std::getline(file, line);) {
    const auto entry = nlohmann::json::parse(line, nullptr, false);
    if (entry.is_discarded() || !entry.contains("state")) continue;   // the last line may be half written
    states.push_back({entry["state"], entry.value("cause", ""), entry.value("look", 0), entry.value("wall_time_ns", std::int64_t{0})});
  }
  return states;
}

// Behind the two lines of its header, with a name of equal length in place of the run's.
std::string without_run_id(std::string model, const std::string& run_id) {
  for (int line = 0; line < 2; ++line) model.erase(0, model.find('\n') + 1);
  for (std::size_t at = 0; (at = model.find(run_id, at)) != std::string::npos;) model.replace(at, run_id.size(), run_id.size(), 'x');
  return model;
}

std::map<std::string, std::string> hashes_of(const fs::path& folder) {
  std::vector<std::string> names{"model.periplus", "model.ply", "model.bt"};
  std::error_code ignored;
  for (const fs::directory_entry& look : fs::directory_iterator(folder / "looks", ignored))
    names.push_back((fs::path("looks") / look.path().filename() / "depth.npy").string());
  std::map<std::string, std::string> hashes;
  for (const std::string& name : names)
    if (fs::exists(folder / name)) {
      const std::string text = read_text(folder / name);
      hashes[name] = sha256_hex(name == "model.periplus" ? without_run_id(text, folder.filename().string()) : text);
    }
  return hashes;
}

}  // namespace

std::vector<std::string> RunResult::state_names() const {
  std::vector<std::string> names;
  for (const StateEntered& s : states) names.push_back(s.state);
  return names;
}

bool RunResult::went(const std::string& from, const std::string& to, const std::string& cause) const {
  for (std::size_t i = 1; i < states.size(); ++i)
    if (states[i - 1].state == from && states[i].state == to && states[i].cause.find(cause) != std::string::npos) return true;
  return false;
}

SystemRun::SystemRun(const RunRequest& request) {
  static std::atomic<int> count{0};
  output_ = fs::temp_directory_path() / ("periplus-scenario-" + std::to_string(::getpid()) + "-" + std::to_string(++count));
  fs::remove_all(output_);
  fs::create_directories(output_);
  log_ = output_ / "terminal.txt";
  std::vector<std::string> arguments{"run", task_file(request.task).string(), "--output", output_.string()};
  for (const std::string& change : request.changes) arguments.insert(arguments.end(), {"--set", change});
  arguments.insert(arguments.end(), request.arguments.begin(), request.arguments.end());
  // Nothing of the person's own stores or background services may be met.
  harness::Program::Environment environment{{"PERIPLUS_DOMAIN", std::to_string(domain_.id())},
                                            {"XDG_STATE_HOME", (output_ / "state").string()},
                                            {"XDG_RUNTIME_DIR", (output_ / "runtime").string()}};
  fs::create_directories(output_ / "runtime");
  for (const auto& [key, value] : request.environment) environment[key] = value;
  program_ = std::make_unique<harness::Program>(std::string(PERIPLUS_BIN_DIR) + "/periplus", arguments, environment, log_.string());
}

SystemRun::~SystemRun() {
  program_.reset();
  std::error_code ignored;
  if (!testing::Test::HasFailure()) fs::remove_all(output_, ignored);
}

fs::path SystemRun::folder() const {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(output_, ignored))
    if (fs::exists(entry.path() / "whiteboard.jsonl", ignored)) return entry.path();
  return {};
}

std::vector<StateEntered> SystemRun::states() const {
  const fs::path run = folder();
  return run.empty() ? std::vector<StateEntered>{} : read_states(run / "whiteboard.jsonl");
}

std::string SystemRun::output() const { return read_text(log_); }

bool SystemRun::wait_for_state(const std::string& state, int look, Milliseconds timeout) {
  for (const auto end = Clock::now() + timeout; Clock::now() < end; std::this_thread::sleep_for(5ms)) {
    const auto all = states();
    if (!all.empty() && all.back().state == state && all.back().look >= look) return true;
    if (!program_->running()) return false;
  }
  return false;
}

pid_t SystemRun::pid_of(const std::string& service) const {
  std::string name = "periplus-" + service;
  std::replace(name.begin(), name.end(), '_', '-');
  std::error_code ignored;
  for (const fs::directory_entry& process : fs::directory_iterator("/proc", ignored)) {
    if (!is_process(process.path().filename())) continue;
    if (parent_of(process.path()) != program_->pid()) continue;
    if (fs::read_symlink(process.path() / "exe", ignored).filename() == name) return std::stoi(process.path().filename().string());
  }
  return 0;
}

std::vector<pid_t> SystemRun::processes() const {
  // Of a zombie the environment is empty.
  const std::string own = "XDG_RUNTIME_DIR=" + (output_ / "runtime").string() + '\0';
  std::vector<pid_t> found;
  std::error_code ignored;
  for (const fs::directory_entry& process : fs::directory_iterator("/proc", ignored))
    if (is_process(process.path().filename()) && read_text(process.path() / "environ").find(own) != std::string::npos)
      found.push_back(std::stoi(process.path().filename().string()));
  return found;
}

bool SystemRun::kill_service(const std::string& service, int signal) {
  const pid_t pid = pid_of(service);
  if (pid == 0 || ::kill(pid, signal) != 0) return false;
  killed_ = Clock::now();
  return true;
}

void SystemRun::interrupt() { program_->signal(SIGINT); }

RunResult SystemRun::finish(Milliseconds timeout) {
  RunResult result;
  result.status = program_->wait(timeout);
  if (killed_) result.seconds_after_kill = std::chrono::duration<double>(Clock::now() - *killed_).count();
  program_->signal(SIGTERM);
  program_->wait(30s);
  result.output = output();
  result.folder = folder();
  result.states = states();
  if (!result.folder.empty() && fs::exists(result.folder / "report.json"))
    result.report = nlohmann::json::parse(read_text(result.folder / "report.json"), nullptr, false);
  if (!result.folder.empty()) result.hashes = hashes_of(result.folder);
  return result;
}

std::vector<std::string> shared_memory_left(int domain, const std::vector<std::string>& before) {
  const std::string folder = "/dev/shm/";
  std::set<std::string> left;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename();
    if (is_port_of_another(name, domain)) continue;
    if (name.find("fastrtps_") != std::string::npos && std::find(before.begin(), before.end(), name) == before.end()) left.insert(name);
  }
  std::set<std::string> used;
  for (const fs::directory_entry& process : fs::directory_iterator("/proc", ignored)) {
    if (!is_process(process.path().filename())) continue;
    std::ifstream maps(process.path() / "maps");
    for (std::string line; std::getline(maps, line);)
      if (const std::size_t at = line.find(folder); at != std::string::npos) used.insert(line.substr(at + folder.size()));
    for (const fs::directory_entry& file : fs::directory_iterator(process.path() / "fd", ignored)) {
      const std::string target = fs::read_symlink(file.path(), ignored).string();
      if (target.starts_with(folder)) used.insert(target.substr(folder.size()));
    }
  }
  for (const std::string& name : used) left.erase(name);
  return {left.begin(), left.end()};
}

}  // namespace periplus::scenarios
