// Runs the state table: performs the present state's action, takes the transition that its outcome triggers, until an end.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "services/supervisor/state_table.h"
#include "services/supervisor/task.h"

namespace periplus::supervisor {

struct Outcome {
  Trigger trigger = Trigger::done;
  std::string cause;   // for a person; empty: the table's own words
};

// What the states do. Over DDS in the product, scripted in tests.
class Actions {
 public:
  virtual ~Actions() = default;
  virtual Outcome perform(State state) = 0;
  // What cuts the run short, if anything does.
  virtual std::optional<Outcome> interruption() const = 0;
};

struct MachineResult {
  State end = State::service_lost;
  std::string cause;   // what led to the end
};

// `entered(state, cause)` is called before each state's action, the end included. An interruption is looked for between states;
// an action that it cuts short returns it. Halt and the ends are not interrupted.
MachineResult run_machine(Actions& actions, const std::function<void(State, const std::string& cause)>& entered);

// When the model is complete (thesis 5.1.2): the promised gain falls under the least gain, or the last three promises differ
// by less than the variation. Voxels close to a surface may stay undecided from wherever they are looked at, and are promised again
// each time: so a promise is worth no more than the share that the last looks found of theirs.
class StopRule {
 public:
  explicit StopRule(const StopSettings& settings) : settings_(settings) {}
  // done, gain_small or converged for a view that promises `gain_voxels` at `look`; a promise at the same look replaces the
  // one before (the pose was forbidden).
  Trigger judge(int look, double gain_voxels);
  // A look that was promised `promised` voxels found `found`.
  void looked(double promised, double found);
  // Share of a promise that may be expected, 0..1.
  double trust() const;

 private:
  StopSettings settings_;
  std::vector<std::pair<double, double>> yields_;  // promised, found
  std::vector<std::pair<int, double>> promises_;
};

}  // namespace periplus::supervisor
