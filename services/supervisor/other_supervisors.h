// Who else decides on this domain, as its heartbeats tell: one supervisor a domain.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace periplus::supervisor {

// Instances are told apart by their names alone: hosts and process numbers of containers may coincide, and so may nothing be
// concluded from another host's clock. Thread-safe.
class OtherSupervisors {
 public:
  explicit OtherSupervisors(std::string own_instance) : own_(std::move(own_instance)) {}

  // A heartbeat (ServiceStatus) of a supervisor, this one's own included.
  void heard(const std::string& instance, std::uint8_t state);
  // The one that this one gives way to: who is ready already, or, of those that start at the same time, the lesser name.
  std::optional<std::string> stronger() const;

 private:
  const std::string own_;
  mutable std::mutex mutex_;
  std::map<std::string, std::uint8_t> states_;
};

}  // namespace periplus::supervisor
