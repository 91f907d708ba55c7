#include "services/supervisor/supervisor_service.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/core/version.h"
#include "common/dds/codec_impl.h"
#include "common/wire/common_wire.h"
#include "idl/supervisor.h"
#include "services/supervisor/modeling_actions_service.h"

namespace periplus::supervisor {

using namespace std::chrono_literals;

SupervisorSettings read_settings(const config::Node& configuration) {
  SupervisorSettings s;
  configuration.read("wait_for_service_s", s.wait_for_service_s, {.minimum = 0, .maximum = 600});
  configuration.read("request_deadline_s", s.request_deadline_s, {.minimum = 0.1, .maximum = 3600});
  configuration.read("motion_deadline_s", s.motion_deadline_s, {.minimum = 0.1, .maximum = 3600});
  configuration.finish();
  return s;
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
  std::map<std::string, long long> supervisors; // other supervisors' instances -> last heartbeat
  std::string run_id;                           // the last one
  std::string run_folder;
  std::atomic<bool> running{false};
  std::atomic<bool> abort{false};
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
};

SupervisorService::SupervisorService(service::Service& service, const SupervisorSettings& settings) : impl_(std::make_unique<Impl>(service, settings)) {
  Impl& i = *impl_;
  i.statuses = std::make_unique<dds::Subscriber<msg::ServiceStatus>>(service.node(), "periplus/service/status", dds::qos_latest(1), [&i](const msg::ServiceStatus& s) {
    std::lock_guard lock(i.mutex);
    const bool gone = s.state() >= 3;
    if (!gone) i.vendors[s.service().to_string()] = s.vendor().to_string();
    if (s.service().to_string() == "supervisor" && s.pid() != static_cast<std::uint32_t>(::getpid())) {
      if (gone)
        i.supervisors.erase(s.instance().to_string());
      else
        i.supervisors[s.instance().to_string()] = s.wall_time_ns();
    }
  });
  service.waiting_for("signs of another supervisor (1.5 s)");
  service.wait_until_stopped(1500ms);
  {
    std::lock_guard lock(i.mutex);
    const long long now = wall_time_ns();
    for (const auto& [instance, seen] : i.supervisors)
      require(now - seen > 3000000000LL, ErrorCode::supervisor_busy,
              "another supervisor (" + instance + ") is already on this domain; stop it with `periplus down`, or choose another domain with PERIPLUS_DOMAIN");
  }
  i.start = service.serve<msg::StartRequest, msg::StartReply>(
      "supervisor/start", [&i](const msg::StartRequest& q, msg::StartReply& r, dds::RpcContext&) { i.begin(q, r); });
  i.abort_rpc = service.serve<msg::AbortRequest, msg::AbortReply>("supervisor/abort", [&i](const msg::AbortRequest& q, msg::AbortReply& r, dds::RpcContext&) {
    const std::string id = wire::id_from_wire(q.run_id(), "run_id", true);
    std::lock_guard lock(i.mutex);
    require(id.empty() || id == i.run_id, ErrorCode::supervisor_no_such_run, "there is no run " + id + " here; `periplus watch` shows the one there is");
    r.was_running(i.running);
    if (i.running) i.abort = true;
  });
}

SupervisorService::~SupervisorService() {
  impl_->abort = true;
  impl_->start.reset();
  impl_->abort_rpc.reset();
  if (impl_->run_thread.joinable()) impl_->run_thread.join();
}

void SupervisorService::Impl::begin(const msg::StartRequest& request, msg::StartReply& reply) {
  const std::string id = wire::id_from_wire(request.run_id(), "run_id");
  Task task = parse_task(wire::text_from_wire(request.task_yaml()), "task", ".");
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
  abort = false;
  event_number = 0;
  run_thread = std::thread([this, task, environment = request.environment()] { run(task, environment); });
}

void SupervisorService::Impl::run(Task task, msg::Environment environment) {
  const auto began = std::chrono::steady_clock::now();
  const long long began_ns = wall_time_ns();
  nlohmann::json report = {{"task", nlohmann::json::object()}, {"schema", 1}};
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
      actions = std::make_unique<ModelingActions>(service.node(), ActionSettings{settings.wait_for_service_s, settings.request_deadline_s, settings.motion_deadline_s},
                                                  task, run_id, environment, recorder, whiteboard, recording, writes, abort, [this](msg::RunEvent e) { publish(std::move(e)); });
      result = run_machine(*actions, entered);
    } catch (const Error& e) {
      result = {e.code() == ErrorCode::bad_input ? State::bad_input : State::service_lost, e.what()};
      entered(result.end, result.cause);
    }
    if (actions) {
      actions->export_models();
      writes.flush();
      report.update(actions->report());
    }
    if (task.truth) recording.save_truth(recorder);
    std::map<std::string, std::string> vendor_by_service;
    {
      std::lock_guard lock(mutex);
      vendor_by_service = vendors;
    }
    report["task"] = task.name;
    report["run_id"] = run_id;
    report["seed"] = task.seed;
    report["voxel_m"] = task.voxel_m;
    report["object_box"] = {{"pose_world_box", to_json(task.box.X_WB)}, {"size_m", {task.box.size.x(), task.box.size.y(), task.box.size.z()}}};
    report["version"] = version();
    report["vendors"] = vendor_by_service;
    report["exit"] = {{"status", exit_status(result.end)}, {"state", to_string(result.end)}, {"reason", result.cause}};
    report["began"] = iso_time(began_ns);
    report["wall_time_s"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    recorder.save_json("report.json", report);
  } catch (const std::exception& e) {
    log::error("the run's files could not be written", {{"cause", e.what()}});
    result = {State::service_lost, std::string("the run's files could not be written: ") + e.what()};
  }
  msg::RunEvent event;
  event.kind("end");
  event.state(to_string(result.end));
  event.cause(result.cause);
  event.exit_status(exit_status(result.end));
  event.text(result.cause);
  publish(event);
  log::info("run ended", {{"state", to_string(result.end)}, {"status", std::to_string(exit_status(result.end))}, {"cause", result.cause}});
  log::flush();
  running = false;
}

}  // namespace periplus::supervisor
