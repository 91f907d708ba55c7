// The supervisor on the bus: supervisor/start, supervisor/abort, and the events of the run under way. One run at a time, one
// supervisor a domain.
#pragma once

#include <memory>
#include <string>

#include "common/service/service.h"

namespace periplus::supervisor {

struct SupervisorSettings {
  double wait_for_service_s = 8;
  double request_deadline_s = 60;
  double motion_deadline_s = 600;
  double view_time_limit_s = 0;    // of the search for a view; 0: none
  std::string log_folder;          // of services that the client did not start; may be empty
};
// Throws Error(bad_input) for what cannot be used.
SupervisorSettings read_settings(const config::Node& configuration);

class SupervisorService {
 public:
  // Throws Error(supervisor_busy) if another supervisor is alive on the domain.
  SupervisorService(service::Service& service, const SupervisorSettings& settings);
  ~SupervisorService();  // aborts a run under way and waits for its end

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::supervisor
