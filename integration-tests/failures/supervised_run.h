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
  // Domain 21..40 by `name`, which is the test's.
  explicit SupervisedRun(const std::string& name, const std::set<std::string>& absent = {});
  static int domain_of(const std::string& name);

  // A task that needs nothing but the robot and a scene of deploy/; `more` are further lines.
  std::string task(const std::string& more = "") const;
  dds::RpcResult start(const std::string& run_id, const std::string& task_yaml, std::string* folder = nullptr);
  dds::RpcResult abort(const std::string& run_id, bool* was_running = nullptr);
  RunEnd wait(const std::string& run_id, std::chrono::seconds timeout = std::chrono::seconds(30));
  // Start and wait.
  RunEnd run(const std::string& more = "");

  harness::TestBench bench;
  ScriptedServices services;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, msg::RunEvent> ends_;
  dds::Subscriber<msg::RunEvent> events_;
  dds::RpcClient<msg::StartRequest, msg::StartReply> start_;
  dds::RpcClient<msg::AbortRequest, msg::AbortReply> abort_;
};

}  // namespace periplus::failures
