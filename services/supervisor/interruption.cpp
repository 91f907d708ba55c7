#include "services/supervisor/interruption.h"

namespace periplus::supervisor {

void Interruption::interrupt(Outcome outcome, bool hasty) {
  const std::lock_guard lock(mutex_);
  if (!outcome_) outcome_ = std::move(outcome);
  hasty_ = hasty_ || hasty;
}

void Interruption::abort() { interrupt({Trigger::abort, "aborted by the user"}, false); }

void Interruption::lose(const std::string& what) { interrupt({Trigger::lost, what}, true); }

void Interruption::stop() { interrupt({Trigger::abort, "the supervisor was stopped"}, true); }

void Interruption::clear() {
  const std::lock_guard lock(mutex_);
  outcome_.reset();
  hasty_ = false;
}

std::optional<Outcome> Interruption::outcome() const {
  const std::lock_guard lock(mutex_);
  return outcome_;
}

bool Interruption::hasty() const {
  const std::lock_guard lock(mutex_);
  return hasty_;
}

}  // namespace periplus::supervisor
