// The real supervisor among scripted services: starts a run on the bus and tells how it ended.
#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/dds/node.h"
#include "common/dds/rpc.h"
#include "idl/model.h"
#include "idl/supervisor.h"
#include "integration-tests/failures/scripted_services.h"
#include "integration-tests/harness/test_bench.h"

namespace periplus::failures {

struct RunEnd {
  int status = -1;                       // -1: no end within the time
  std::string reason;
  std::vector<std::string> states;       // of the whiteboard, in the order entered
  nlohmann::json report;                 // null where there is none
  // The states as one line, for comparisons that read well.
  std::string trace() const;
  bool ends_with(const std::string& states_line) const;
};

// States of whiteboard.jsonl and report.json of a run's folder.
RunEnd read_run(const std::string& folder);

class SupervisedRun {
 public:
  // `name` is the test's.
  explicit SupervisedRun(const std::string& name, const std::set<std::string>& absent = {});

  // A task that needs nothing but the robot and a scene of deploy/; `more` are further lines.
  std::string task(const std::string& more = "") const;
  dds::RpcResult start(const std::string& run_id, const std::string& task_yaml, std::string* folder = nullptr);
  // `lost`: the service whose loss is told; empty: the user's wish.
  dds::RpcResult abort(const std::string& run_id, bool* was_running = nullptr, const std::string& lost = "");
  RunEnd wait(const std::string& run_id, std::chrono::seconds timeout = std::chrono::seconds(30));
  // Start and wait.
  RunEnd run(const std::string& more = "");
  std::string folder(const std::string& run_id) const { return bench.folder() + "/runs/" + run_id; }
  // The environment that start() sends.
  const msg::Environment& environment() const { return environment_; }

  harness::TestBench bench;
  ScriptedServices services;
  harness::Program& supervisor;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, msg::RunEvent> ends_;
  dds::Subscriber<msg::RunEvent> events_;
  dds::RpcClient<msg::StartRequest, msg::StartReply> start_;
  dds::RpcClient<msg::AbortRequest, msg::AbortReply> abort_;
  const msg::Environment environment_;
};

}  // namespace periplus::failures
