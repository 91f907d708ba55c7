#include "services/supervisor/cli/commands.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <thread>

#include "common/core/config.h"
#include "common/core/locate.h"
#include "services/supervisor/cli/doctor.h"
#include "services/supervisor/cli/process.h"
#include "services/supervisor/cli/session.h"
#include "services/supervisor/cli/shared_memory.h"

namespace periplus::supervisor::cli {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

namespace {

std::string the_object(Client& client, const std::string& object_id) {
  if (!object_id.empty()) return object_id;
  const std::vector<std::string> objects = client.objects();
  if (objects.size() == 1) return objects.front();
  std::string names;
  for (const std::string& name : objects) names += " " + name;
  throw Error(ErrorCode::bad_input, objects.empty() ? "the model server has no object yet; run a task first" : "which object? there are" + names);
}

}  // namespace

int show_status() {
  const Interrupts interrupts;
  Session session;
  const auto rows = session.client().services();
  if (rows.empty()) {
    std::cout << "nobody is on domain " << session.client().domain() << "\n";
    return 1;
  }
  std::cout << service_table(rows);
  const auto missing = awaited(rows);
  for (const std::string& name : missing) std::cout << "awaited: " << name << "\n";
  return missing.empty() ? 0 : 1;
}

int watch() {
  const Interrupts interrupts;
  Session session;
  RunView view;
  std::string run;
  while (Interrupts::count() == 0) {
    for (const RunEvent& event : session.client().take_events()) {
      if (event.run_id != run) {
        run = event.run_id;
        view = RunView();
        std::cout << "run " << run << "\n" << RunView::header();
      }
      std::cout << view.add(event) << std::flush;
    }
    std::this_thread::sleep_for(100ms);
  }
  return 0;
}

int abort_run(const std::string& run_id) {
  Client client;
  const bool was_running = client.abort(run_id);
  std::cout << (was_running ? "aborting; the robot comes to a stand\n" : "no run is under way\n");
  return 0;
}

int export_model(const std::string& object_id, const std::string& format, const std::string& output) {
  Client client;
  const std::string object = the_object(client, object_id);
  const std::vector<std::uint8_t> data = client.export_model(object, format);
  const std::string file = output.empty() ? object + "." + format : output;
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
  out.close();
  require(!out.fail(), ErrorCode::io, "cannot write " + file + "; choose another with --output");
  std::cout << file << ": " << data.size() << " bytes\n";
  return 0;
}

int print_digest(const std::string& object_id) {
  Client client;
  const std::string object = the_object(client, object_id);
  const ModelDigest d = client.digest(object);
  std::cout << d.digest << "  " << object << "  revision " << d.revision << ", " << d.views << " views, " << d.known << " known, " << d.unknown << " unknown, " << d.empty
            << " empty, " << d.environment << " environment voxels\n";
  return 0;
}

int make_report(const std::string& run, const std::vector<std::string>& options) {
  const fs::path folder = find_run(run);
  const fs::path program = find_program("report", executable_folder());
  require(!program.empty(), ErrorCode::io, "periplus-report is not installed beside this program; install the package periplus-client or build it");
  std::vector<std::string> arguments{folder.string()};
  arguments.insert(arguments.end(), options.begin(), options.end());
  Process process({.program = program, .arguments = arguments, .environment = {}, .output = {}});
  std::optional<int> status;
  while (!(status = process.wait(1s))) {
  }
  return *status;
}

int doctor(bool clean) {
  if (clean) std::cout << "removed " << clean_shared_memory() << " files of killed processes\n";
  std::vector<Finding> findings = check_programs(executable_folder());
  const auto add = [&findings](std::vector<Finding> more) { findings.insert(findings.end(), more.begin(), more.end()); };
  add(check_shared_memory());
  add(check_socket_buffers());
  {
    const Interrupts interrupts;
    Session session;
    add(check_domain(session.client().services(), session.client().domain()));
  }
  std::cout << to_text(findings);
  for (const Finding& finding : findings)
    if (finding.grade == Finding::Grade::bad) return 1;
  return 0;
}

int exit_status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::bad_input:
    case ErrorCode::bad_size:
    case ErrorCode::not_finite:
    case ErrorCode::unknown_id:
    case ErrorCode::io:
    case ErrorCode::sim_scene_bad:
    case ErrorCode::model_object_unknown:
    case ErrorCode::supervisor_busy:
    case ErrorCode::supervisor_bad_task:
    case ErrorCode::supervisor_no_such_run: return 2;
    case ErrorCode::supervisor_service_lost: return 5;
    case ErrorCode::cancelled: return 130;
    default: return 1;
  }
}

bool is_of_database(const std::vector<std::string>& arguments) {
  if (arguments.size() < 2 || arguments[0] != "model" || arguments[1].starts_with("-")) return false;
  if (arguments[1] != "export" && arguments[1] != "digest") return true;
  return std::any_of(arguments.begin(), arguments.end(), [](const std::string& a) { return a.starts_with("--store"); });
}

fs::path find_program(const std::string& verb, const fs::path& folder) {
  if (verb.empty() || verb.find('/') != std::string::npos) return {};
  const std::string name = "periplus-" + verb;
  std::vector<fs::path> folders{folder};
  if (const char* path = std::getenv("PATH")) {
    std::istringstream parts(path);
    for (std::string part; std::getline(parts, part, ':');)
      if (!part.empty()) folders.emplace_back(part);
  }
  for (const fs::path& place : folders)
    if (::access((place / name).c_str(), X_OK) == 0 && fs::is_regular_file(place / name)) return place / name;
  return {};
}

std::string no_such_command(const std::string& verb, const std::vector<std::string>& verbs) {
  return "periplus: there is no command '" + verb + "'; did you mean '" + config::nearest(verb, verbs) + "'? `periplus --help` lists them";
}

fs::path find_run(const std::string& run) {
  for (const fs::path& folder : {fs::path(run), fs::path("runs") / run})
    if (fs::is_directory(folder)) return fs::absolute(folder);
  throw Error(ErrorCode::bad_input, "there is no run folder " + run + ", nor runs/" + run + "; give one that exists");
}

}  // namespace periplus::supervisor::cli
