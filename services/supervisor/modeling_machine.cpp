#include "services/supervisor/modeling_machine.h"

#include <algorithm>

namespace periplus::supervisor {

MachineResult run_machine(Actions& actions, const std::function<void(State, const std::string&)>& entered) {
  State state = State::prepare;
  std::string cause = "run started";
  for (;;) {
    entered(state, cause);
    if (is_end(state)) return {state, cause};
    const std::optional<Outcome> interruption = state == State::halt ? std::nullopt : actions.interruption();
    const Outcome outcome = interruption ? *interruption : actions.perform(state);
    const State next = next_state(state, outcome.trigger);
    // A way out keeps the cause that led into it: "posture not reached: ...", not "standing".
    if (state != State::return_half_sitting && state != State::halt) {
      cause = outcome.cause;
      for (const Transition& t : transitions())
        if (cause.empty() && (t.from == state || t.from == State::modeling) && t.trigger == outcome.trigger) cause = t.why;
    }
    state = next;
  }
}

void StopRule::looked(double promised, double found) {
  if (promised > 0) yields_.emplace_back(promised, found);
}

double StopRule::trust() const {
  const auto count = static_cast<std::size_t>(settings_.discount_looks);
  if (count == 0 || yields_.size() < count) return 1;
  double promised = 0, found = 0;
  for (auto it = yields_.end() - settings_.discount_looks; it != yields_.end(); ++it) promised += it->first, found += it->second;
  return std::clamp(found / promised, 0.0, 1.0);
}

Trigger StopRule::judge(int look, double gain_voxels) {
  if (!promises_.empty() && promises_.back().first == look) promises_.pop_back();
  promises_.emplace_back(look, gain_voxels);
  if (gain_voxels * trust() < settings_.least_gain_voxels) return Trigger::gain_small;
  if (promises_.size() >= 3) {
    const auto last = promises_.end() - 3;
    const auto [low, high] = std::minmax({last[0].second, last[1].second, last[2].second});
    if (high - low < settings_.variation_voxels) return Trigger::converged;
  }
  return Trigger::done;
}

}  // namespace periplus::supervisor
