// What the states of a modelling run do, over DDS: the calls to the other services, the recorder and the whiteboard.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "idl/model.h"
#include "idl/supervisor.h"
#include "services/supervisor/modeling_machine.h"
#include "services/supervisor/recording_service.h"
#include "services/supervisor/run_recorder.h"
#include "services/supervisor/task.h"
#include "services/supervisor/whiteboard.h"
#include "services/supervisor/write_queue.h"

namespace periplus::supervisor {

// Deadlines and patience with the other services; services/supervisor/config/default.yaml.
struct ActionSettings {
  double wait_for_service_s = 8;   // for a lost one to come back, or for another instance
  double request_deadline_s = 60;  // capture, process, integrate, plan
  double motion_deadline_s = 600;  // walk, set posture
};

class ModelingActions : public Actions {
 public:
  // `publish` sends an event to whoever watches; it fills in the run's id and the number.
  ModelingActions(dds::Node& node, const ActionSettings& settings, const Task& task, const std::string& run_id, const msg::Environment& environment,
                  RunRecorder& recorder, Whiteboard& whiteboard, Recording& recording, WriteQueue& writes, const std::atomic<bool>& abort,
                  std::function<void(msg::RunEvent)> publish);
  ~ModelingActions() override;

  Outcome perform(State state) override;
  bool abort_requested() const override { return abort_; }

  // After the end: exports the models; looks, views and forbidden poses for the report. Never throws: says what failed in the log.
  void export_models();
  nlohmann::json report() const;
  int look() const;

 private:
  Outcome act(State state);
  struct Impl;
  std::unique_ptr<Impl> impl_;
  const std::atomic<bool>& abort_;
};

}  // namespace periplus::supervisor
