// What the states of a modelling run do, over DDS: the calls to the other services, the recorder and the whiteboard.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "idl/model.h"
#include "idl/supervisor.h"
#include "services/supervisor/interruption.h"
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
  double view_time_limit_s = 0;    // of the search for a view; 0: none
};

class ModelingActions : public Actions {
 public:
  // `publish` sends an event to whoever watches; it fills in the run's id and the number.
  ModelingActions(dds::Node& node, const ActionSettings& settings, const Task& task, const std::string& run_id, const msg::Environment& environment,
                  RunRecorder& recorder, Whiteboard& whiteboard, Recording& recording, WriteQueue& writes, const Interruption& interruption,
                  std::function<void(msg::RunEvent)> publish);
  ~ModelingActions() override;

  Outcome perform(State state) override;
  std::optional<Outcome> interruption() const override { return interruption_.outcome(); }

  // After the end: exports the models, unless the run was cut short in haste. Never throws: says what failed in the log.
  void export_models();
  // Looks, views and forbidden poses so far.
  nlohmann::json report() const;
  int look() const;

 private:
  Outcome act(State state);
  struct Impl;
  std::unique_ptr<Impl> impl_;
  const Interruption& interruption_;
};

}  // namespace periplus::supervisor
