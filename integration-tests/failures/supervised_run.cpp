#include "integration-tests/failures/supervised_run.h"

#include <chrono>
#include <fstream>
#include <sstream>

#include "common/dds/codec_impl.h"
#include "common/scene/scene.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_wire.h"

namespace periplus::failures {

using namespace std::chrono_literals;

std::string RunEnd::trace() const {
  std::string line;
  for (const std::string& state : states) line += (line.empty() ? "" : " ") + state;
  return line;
}

bool RunEnd::ends_with(const std::string& states_line) const { return (" " + trace()).ends_with(" " + states_line); }

RunEnd read_run(const std::string& folder) {
  RunEnd end;
  std::ifstream board(folder + "/whiteboard.jsonl");
  for (std::string line; std::getline(board, line);) {
    const nlohmann::json entry = nlohmann::json::parse(line);
    if (entry.contains("state")) end.states.push_back(entry.at("state"));
  }
  if (std::ifstream file(folder + "/report.json"); file) {
    end.report = nlohmann::json::parse(file);
    end.status = end.report.at("exit").value("status", -1);
    end.reason = end.report.at("exit").at("reason");
  }
  return end;
}

SupervisedRun::SupervisedRun(const std::string& name, const std::set<std::string>& absent)
    : bench(name),
      services(bench.node(), bench.robot(), absent),
      supervisor(bench.start("periplus-supervisor", {"--set", "wait_for_service_s=1.5"})),
      events_(bench.node(), "periplus/supervisor/event", dds::qos_latest(256),
              [this](const msg::RunEvent& event) {
                if (event.kind().to_string() != "end") return;
                const std::lock_guard lock(mutex_);
                ends_[event.run_id().to_string()] = event;
                changed_.notify_all();
              }),
      start_(bench.node(), "supervisor/start"),
      abort_(bench.node(), "supervisor/abort"),
      environment_(wire::environment_to_wire("ball-on-table", harness::BallOnTable::scene_yaml(), bench.robot_yaml(), bench.robot_urdf())) {}

std::string SupervisedRun::task(const std::string& more) const {
  const std::string deploy = std::string(PERIPLUS_SOURCE_DIR) + "/deploy";
  return "schema: 1\nname: failures\nrobot: " + deploy + "/robots/hrp2like.yaml\nscene: " + deploy +
         "/scenes/bunny.yaml\nobject: {id: thing, box_center_m: [0, 0, 0.98], box_size_m: [0.6, 0.6, 0.56]}\nvoxel_m: 0.02\ntruth: false\n"
         "output: " + bench.folder() + "/runs\n" + more;
}

dds::RpcResult SupervisedRun::start(const std::string& run_id, const std::string& task_yaml, std::string* folder) {
  msg::StartRequest request;
  request.run_id(run_id);
  request.task_yaml(wire::text_to_wire(task_yaml));
  request.environment(environment_);
  msg::StartReply reply;
  const dds::RpcResult result = start_.call(request, reply, {.deadline = 20s, .wait_for_server = 15s});
  if (folder) *folder = reply.run_folder().to_string();
  return result;
}

dds::RpcResult SupervisedRun::abort(const std::string& run_id, bool* was_running, const std::string& lost) {
  msg::AbortRequest request;
  request.run_id(run_id);
  request.lost(lost);
  msg::AbortReply reply;
  const dds::RpcResult result = abort_.call(request, reply, {.deadline = 10s, .wait_for_server = 15s});
  if (was_running) *was_running = reply.was_running();
  return result;
}

RunEnd SupervisedRun::wait(const std::string& run_id, std::chrono::seconds timeout) {
  RunEnd end;
  {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, timeout, [&] { return ends_.contains(run_id); })) return end;
    end.status = ends_[run_id].exit_status();
    end.reason = ends_[run_id].text().to_string();
  }
  const RunEnd files = read_run(folder(run_id));
  end.states = files.states;
  end.report = files.report;
  return end;
}

RunEnd SupervisedRun::run(const std::string& more) {
  const dds::RpcResult result = start("run", task(more));
  if (!result.ok()) {
    RunEnd refused;
    refused.reason = std::string(dds::to_string(result.status)) + ": " + result.error_message;
    return refused;
  }
  return wait("run");
}

}  // namespace periplus::failures
