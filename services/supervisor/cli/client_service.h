// The command-line client's place on the bus: who is there, what happens, and requests to supervisor and model server.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/scene/environment_texts.h"
#include "services/supervisor/cli/run_view.h"
#include "services/supervisor/cli/service_table.h"

namespace periplus::supervisor::cli {

using scene::EnvironmentTexts;

struct ModelDigest {
  std::string digest;                     // SHA-256
  unsigned revision = 0, views = 0;
  unsigned long long known = 0, unknown = 0, empty = 0, environment = 0;
};

// Failures are Errors: supervisor_service_lost if nobody answers, otherwise the service's own.
class Client {
 public:
  Client();  // vendor, domain, interface and peers from the environment
  ~Client();

  int domain() const;
  // Everyone heard so far who did not say good-bye.
  std::vector<ServiceRow> services() const;
  // What happened since the last call; the first one also tells of the last run.
  std::vector<RunEvent> take_events();

  // Returns the run's folder.
  std::string start(const std::string& run_id, const std::string& task_yaml, const EnvironmentTexts& environment);
  // True if a run was under way. An empty id means whichever runs.
  bool abort(const std::string& run_id);
  // Tells the supervisor that a service is gone and nobody brings it back, so that the run ends as such. False if it does not
  // answer within 2 s.
  bool report_loss(const std::string& run_id, const std::string& what);

  // Objects that the model server published, waiting up to two seconds for the first.
  std::vector<std::string> objects();
  ModelDigest digest(const std::string& object_id);
  // format: periplus | ply | bt.
  std::vector<std::uint8_t> export_model(const std::string& object_id, const std::string& format);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::supervisor::cli
