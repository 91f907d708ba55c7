// Whether a service is the only one of its name on the domain, as heartbeats tell. For those of which there must be one: a supervisor
// decides, a model server remembers; requests spread over two of them would give each a part of the run.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/core/error.h"

namespace periplus::service {

class Service;

// Instances are told apart by their names alone: hosts and process numbers of containers may coincide, and so may nothing be
// concluded from another host's clock. Thread-safe.
class OtherInstances {
 public:
  explicit OtherInstances(std::string own_instance) : own_(std::move(own_instance)) {}

  // A heartbeat (ServiceStatus) of a service of this one's name, its own included.
  void heard(const std::string& instance, std::uint8_t state);
  // The one that this one gives way to: who is ready already, or, of those that start at the same time, the lesser name.
  std::optional<std::string> stronger() const;

 private:
  const std::string own_;
  mutable std::mutex mutex_;
  std::map<std::string, std::uint8_t> states_;
};

// Listens for 1.5 s, then throws Error(code) if `service`, which goes by `name` ("model_server"), has to give way to another. To be called
// before it serves anything.
void require_alone(Service& service, const std::string& name, ErrorCode code);

}  // namespace periplus::service
