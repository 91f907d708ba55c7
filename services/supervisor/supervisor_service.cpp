#include "services/supervisor/supervisor_service.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "common/core/clock.h"
#include "common/core/error.h"
#include "common/core/log.h"
#include "common/core/version.h"
#include "common/dds/codec_impl.h"
#include "common/service/other_instances.h"
#include "common/wire/common_wire.h"
#include "idl/supervisor.h"
#include "services/supervisor/interruption.h"
#include "services/supervisor/modeling_actions_service.h"

namespace periplus::supervisor {

using namespace std::chrono_literals;

SupervisorSettings read_settings(const config::Node& configuration) {
  SupervisorSettings s;
  configuration.read("wait_for_service_s", s.wait_for_service_s, {.minimum = 0, .maximum = 600});
  configuration.read("request_deadline_s", s.request_deadline_s, {.minimum = 0.1, .maximum = 3600});
  configuration.read("motion_deadline_s", s.motion_deadline_s, {.minimum = 0.1, .maximum = 3600});
  configuration.read("view_time_limit_s", s.view_time_limit_s, {.minimum = 0, .maximum = 3600});
  configuration.read("log_folder", s.log_folder);
  configuration.finish();
  return s;
}

// Copies what stands there by now; a log that cannot be copied is said in our own.
void collect_logs(const std::string& from, const std::string& run_folder) {
  namespace fs = std::filesystem;
  std::error_code problem;
  fs::create_directories(fs::path(run_folder) / "logs", problem);
  for (const fs::directory_entry& entry : fs::directory_iterator(from, problem)) {
    if (entry.path().extension() != ".jsonl") continue;
    std::error_code refused;
    fs::copy_file(entry.path(), fs::path(run_folder) / "logs" / entry.path().filename(), fs::copy_options::overwrite_existing, refused);
    if (refused) log::warn("a service's log could not be copied", {{"file", entry.path().string()}, {"cause", refused.message()}});
  }
  if (problem) log::warn("no logs of other services in the run's folder", {{"folder", from}, {"cause", problem.message()}});
}

struct SupervisorService::Impl {
  Impl(service::Service& s, const SupervisorSettings& t)
      : service(s), settings(t), recording(s.node()), events(s.node(), "periplus/supervisor/event", dds::qos_latest(256)) {}

  service::Service& service;
  SupervisorSettings settings;
  Recording recording;
  dds::Publisher<msg::RunEvent> events;

  std::mutex mutex;
  std::map<std::string, std::string> vendors;   // service -> vendor, by its heartbeats
  std::string run_id;                           // the last one
  std::string run_folder;
  std::atomic<bool> running{false};
  Interruption interruption;
  std::atomic<std::uint32_t> event_number{0};
  std::thread run_thread;

  std::unique_ptr<dds::Subscriber<msg::ServiceStatus>> statuses;
  std::shared_ptr<dds::RpcServer<msg::StartRequest, msg::StartReply>> start;
  std::shared_ptr<dds::RpcServer<msg::AbortRequest, msg::AbortReply>> abort_rpc;

  void publish(msg::RunEvent event) {
    event.run_id(run_id);
    event.number(event_number++);
    event.wall_time_ns(wall_time_ns());
    event.run_folder(run_folder);
    events.publish(event);
  }
  void begin(const msg::StartRequest& request, msg::StartReply& reply);
  void run(Task task, msg::Environment environment);
  // report.json but for how the run ended. `actions` may be null.
  nlohmann::json report_of(const Task& task, const ModelingActions* actions, std::chrono::steady_clock::time_point began, long long began_ns);
};

SupervisorService::SupervisorService(service::Service& service, const SupervisorSettings& settings) : impl_(std::make_unique<Impl>(service, settings)) {
  Impl& i = *impl_;
  i.statuses = std::make_unique<dds::Subscriber<msg::ServiceStatus>>(service.node(), "periplus/service/status", dds::qos_latest(1), [&i](const msg::ServiceStatus& s) {
    std::lock_guard lock(i.mutex);
    if (s.state() < 3) i.vendors[s.service().to_string()] = s.vendor().to_string();
  });
  service::require_alone(service, "supervisor", ErrorCode::supervisor_busy);
  i.start = service.serve<msg::StartRequest, msg::StartReply>(
      "supervisor/start", [&i](const msg::StartRequest& q, msg::StartReply& r, dds::RpcContext&) { i.begin(q, r); });
  i.abort_rpc = service.serve<msg::AbortRequest, msg::AbortReply>("supervisor/abort", [&i](const msg::AbortRequest& q, msg::AbortReply& r, dds::RpcContext&) {
    const std::string id = wire::id_from_wire(q.run_id(), "run_id", true);
    std::lock_guard lock(i.mutex);
    require(id.empty() || id == i.run_id, ErrorCode::supervisor_no_such_run, "there is no run " + id + " here; `periplus watch` shows the one there is");
    r.was_running(i.running);
    if (!i.running) return;
    const std::string lost = q.lost().to_string();
    lost.empty() ? i.interruption.abort() : i.interruption.lose(lost);
  });
}

SupervisorService::~SupervisorService() {
  impl_->start.reset();   // first: a run that begins clears what interrupted the one before
  impl_->abort_rpc.reset();
  impl_->interruption.stop();
  if (impl_->run_thread.joinable()) impl_->run_thread.join();
}

void SupervisorService::Impl::begin(const msg::StartRequest& request, msg::StartReply& reply) {
  const std::string id = wire::id_from_wire(request.run_id(), "run_id");
  Task task;
  try {
    // The files that it names stand on the client's computer; what they say came along.
    task = parse_task(wire::text_from_wire(request.task_yaml()), "task", std::nullopt);
  } catch (const Error& e) {
    throw_error(ErrorCode::supervisor_bad_task, e.what());
  }
  std::lock_guard lock(mutex);
  if (running && id == run_id) {  // asked twice
    reply.run_folder(run_folder);
    return;
  }
  require(!running, ErrorCode::supervisor_busy, "run " + run_id + " is under way; wait for it, or end it with `periplus abort`");
  if (run_thread.joinable()) run_thread.join();
  run_id = id;
  run_folder = std::filesystem::absolute(std::filesystem::path(task.output) / id).string();
  require(run_folder.size() < 1024, ErrorCode::bad_input, "the run folder's path is longer than 1023 characters; choose a shorter output");
  RunRecorder check(run_folder);  // refuses what cannot be written before the run begins
  reply.run_folder(run_folder);
  running = true;
  interruption.clear();
  event_number = 0;
  try {
    run_thread = std::thread([this, task, environment = request.environment()] { run(task, environment); });
  } catch (const std::system_error& e) {
    running = false;
    throw_error(ErrorCode::internal, std::string("no thread for the run: ") + e.what() + "; close other programs, or allow this user more processes");
  }
}

nlohmann::json SupervisorService::Impl::report_of(const Task& task, const ModelingActions* actions, std::chrono::steady_clock::time_point began, long long began_ns) {
  nlohmann::json report = {{"schema", 1},
                           {"task", task.name},
                           {"run_id", run_id},
                           {"seed", task.seed},
                           {"voxel_m", task.voxel_m},
                           {"object_box", to_json(task.box)},
                           {"version", version()},
                           {"began", iso_time(began_ns)},
                           {"wall_time_s", seconds_since(began)}};
  if (actions) report.update(actions->report());
  const std::lock_guard lock(mutex);
  report["vendors"] = vendors;
  return report;
}

void SupervisorService::Impl::run(Task task, msg::Environment environment) {
  const auto began = std::chrono::steady_clock::now();
  const long long began_ns = wall_time_ns();
  MachineResult result{State::service_lost, ""};
  try {
    recording.clear();
    RunRecorder recorder(run_folder);
    recorder.save_text("task.yaml", task.yaml());
    recorder.save_text("scene.yaml", wire::text_from_wire(environment.scene_yaml()));
    recorder.save_text("robot.yaml", wire::text_from_wire(environment.robot_yaml()));
    recorder.save_text("robot.urdf", wire::text_from_wire(environment.robot_urdf()));
    Whiteboard whiteboard(run_folder + "/whiteboard.jsonl");
    WriteQueue writes;
    std::unique_ptr<ModelingActions> actions;
    const auto entered = [&](State state, const std::string& cause) {
      const int look = actions ? actions->look() : 0;
      if (!is_end(state)) {  // a supervisor that is killed leaves the report as it stood last, without an exit status
        nlohmann::json report = report_of(task, actions.get(), began, began_ns);
        report["exit"] = {{"state", "unfinished"}, {"reason", std::string("written when the run entered ") + to_string(state) + "; it did not get to its end"}};
        recorder.save_json("report.json", report);
      }
      whiteboard.entered(to_string(state), cause, look);
      log::info("state", {{"state", to_string(state)}, {"cause", cause}, {"look", std::to_string(look)}});
      if (is_end(state)) return;  // told once the files stand
      msg::RunEvent event;
      event.kind("state");
      event.state(to_string(state));
      event.cause(cause);
      event.look(static_cast<std::uint32_t>(look));
      publish(event);
    };
    try {
      actions = std::make_unique<ModelingActions>(service.node(), ActionSettings{settings.wait_for_service_s, settings.request_deadline_s, settings.motion_deadline_s, settings.view_time_limit_s},
                                                  task, run_id, environment, recorder, whiteboard, recording, writes, interruption, [this](msg::RunEvent e) { publish(std::move(e)); });
      result = run_machine(*actions, entered);
    } catch (const Error& e) {
      result = {e.code() == ErrorCode::bad_input ? State::bad_input : State::service_lost, e.what()};
      entered(result.end, result.cause);
    }
    if (actions) {
      actions->export_models();
      writes.flush();
    }
    if (task.truth) recording.save_truth(recorder);
    nlohmann::json report = report_of(task, actions.get(), began, began_ns);
    report["exit"] = {{"status", exit_status(result.end)}, {"state", to_string(result.end)}, {"reason", result.cause}};
    recorder.save_json("report.json", report);
  } catch (const std::exception& e) {
    log::error("the run's files could not be written", {{"cause", e.what()}});
    result = {State::service_lost, std::string("the run's files could not be written: ") + e.what()};
  }
  if (!settings.log_folder.empty()) {
    log::flush();
    collect_logs(settings.log_folder, run_folder);
  }
  msg::RunEvent event;
  event.kind("end");
  event.state(to_string(result.end));
  event.cause(result.cause);
  event.exit_status(exit_status(result.end));
  event.text(result.cause);
  running = false;  // who hears of the end may begin the next run at once, which waits for this thread
  publish(event);
  log::info("run ended", {{"state", to_string(result.end)}, {"status", std::to_string(exit_status(result.end))}, {"cause", result.cause}});
  log::flush();
}

}  // namespace periplus::supervisor
