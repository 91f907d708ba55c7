// The decision of thesis 5.2.1 (Fig. 5.2) as one table: states, their superstates, and what leads from one to the next.
#pragma once

#include <string>
#include <vector>

namespace periplus::supervisor {

enum class State {
  // superstates
  modeling, observe, decide, move, end,
  // observe
  prepare, grab_images, set_half_sitting, process_images, integrate_view,
  // decide
  next_view, generate_posture, plan_steps,
  // move
  walk, set_posture,
  // ways out
  return_half_sitting, halt,
  // ends
  complete, bad_input, spent, no_reachable_view, service_lost, robot_fault, aborted,
};

enum class Trigger {
  done,             // the state did what it is for
  failed,           // it did not; the cause says why
  refused,          // the request itself cannot be served (bad input)
  view_lost,        // vision no longer has the images of this look
  perception_lost,  // the model server did not get this look's perception
  infeasible,       // no posture puts the camera there
  no_path,          // no steps lead there
  gain_small,       // the best view promises less than the least gain
  converged,        // the last promises hardly differ
  budget_spent,     // looks or time
  no_view,          // no view satisfies the constraints, or too many were forbidden at this look
  lost,             // a service is gone and nobody took over
  abort,            // the user wants to stop
};

struct Transition {
  State from;
  Trigger trigger;
  State to;
  const char* why;
};

// Rows of a state are looked up before those of its superstate, and so on up to `modeling`.
const std::vector<Transition>& transitions();
// The superstate; `modeling` and `end` are their own.
State parent(State state);
bool is_end(State state);
// 0 complete, 2 bad input, 3 looks or time spent, 4 no reachable view, 5 a service lost, 6 robot fault, 130 aborted.
int exit_status(State end_state);

const char* to_string(State state);
const char* to_string(Trigger trigger);

// Where `trigger` leads from `state`; throws Error(internal) if the table does not say.
State next_state(State state, Trigger trigger);

// The table as a Graphviz digraph with a cluster for each superstate.
std::string states_dot();

}  // namespace periplus::supervisor
