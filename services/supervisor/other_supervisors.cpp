#include "services/supervisor/other_supervisors.h"

namespace periplus::supervisor {

namespace {
constexpr std::uint8_t kStarting = 0, kStopping = 3;
constexpr std::size_t kMostInstances = 64;
}  // namespace

void OtherSupervisors::heard(const std::string& instance, std::uint8_t state) {
  if (instance == own_) return;
  const std::lock_guard lock(mutex_);
  if (state >= kStopping)
    states_.erase(instance);
  else if (states_.size() < kMostInstances || states_.contains(instance))
    states_[instance] = state;
}

std::optional<std::string> OtherSupervisors::stronger() const {
  const std::lock_guard lock(mutex_);
  for (const auto& [instance, state] : states_)
    if (state != kStarting || instance < own_) return instance;
  return std::nullopt;
}

}  // namespace periplus::supervisor
