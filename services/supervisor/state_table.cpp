#include "services/supervisor/state_table.h"

#include "common/core/error.h"

namespace periplus::supervisor {

const std::vector<Transition>& transitions() {
  using S = State;
  using T = Trigger;
  static const std::vector<Transition> table = {
      // from                  trigger              to                      why
      {S::prepare,             T::done,             S::grab_images,         "model begun, all unknown"},
      {S::prepare,             T::refused,          S::bad_input,           "a service refused the task"},
      {S::prepare,             T::failed,           S::service_lost,        "a service could not take the task"},
      {S::grab_images,         T::done,             S::set_half_sitting,    "images kept"},
      {S::grab_images,         T::failed,           S::return_half_sitting, "capture failed"},
      {S::set_half_sitting,    T::done,             S::process_images,      "standing, or nothing recorded yet"},
      {S::set_half_sitting,    T::failed,           S::robot_fault,         "the robot did not return to half-sitting"},
      {S::process_images,      T::done,             S::integrate_view,      "depth, features, camera pose"},
      {S::process_images,      T::view_lost,        S::set_posture,         "vision was restarted: look again"},
      {S::process_images,      T::failed,           S::robot_fault,         "the images give no depth"},
      {S::integrate_view,      T::done,             S::next_view,           "carved and labelled"},
      {S::integrate_view,      T::perception_lost,  S::process_images,      "have the perception published again"},
      {S::integrate_view,      T::failed,           S::service_lost,        "the model could not take the view"},
      {S::next_view,           T::done,             S::generate_posture,    "a view worth going to"},
      {S::next_view,           T::gain_small,       S::complete,            "gain under the least gain"},
      {S::next_view,           T::converged,        S::complete,            "gain no longer changes"},
      {S::next_view,           T::budget_spent,     S::spent,               "looks or time spent"},
      {S::next_view,           T::no_view,          S::no_reachable_view,   "no view satisfies the constraints"},
      {S::next_view,           T::failed,           S::service_lost,        "planner error"},
      {S::generate_posture,    T::done,             S::plan_steps,          "whole-body posture"},
      {S::generate_posture,    T::infeasible,       S::next_view,           "pose forbidden, again"},
      {S::generate_posture,    T::no_view,          S::no_reachable_view,   "too many forbidden poses at this look"},
      {S::generate_posture,    T::failed,           S::service_lost,        "posture generator error"},
      {S::plan_steps,          T::done,             S::walk,                "footsteps"},
      {S::plan_steps,          T::no_path,          S::next_view,           "pose forbidden, again"},
      {S::plan_steps,          T::no_view,          S::no_reachable_view,   "too many forbidden poses at this look, or no way from here"},
      {S::plan_steps,          T::failed,           S::service_lost,        "walk planner error"},
      {S::walk,                T::done,             S::set_posture,         "arrived"},
      {S::walk,                T::failed,           S::robot_fault,         "walk failed"},
      {S::set_posture,         T::done,             S::grab_images,         "camera in place"},
      {S::set_posture,         T::failed,           S::return_half_sitting, "posture not reached"},
      {S::return_half_sitting, T::done,             S::robot_fault,         "standing"},
      {S::return_half_sitting, T::failed,           S::robot_fault,         "and not even half-sitting was reached"},
      {S::halt,                T::done,             S::aborted,             "robot left standing"},
      {S::halt,                T::failed,           S::aborted,             "the motion controller did not answer"},
      {S::halt,                T::lost,             S::aborted,             "the motion controller is gone"},
      {S::modeling,            T::lost,             S::service_lost,        "a service is gone"},
      {S::modeling,            T::abort,            S::halt,                "aborted by the user"},
  };
  return table;
}

State parent(State state) {
  switch (state) {
    case State::prepare: case State::grab_images: case State::set_half_sitting: case State::process_images:
    case State::integrate_view:
      return State::observe;
    case State::next_view: case State::generate_posture: case State::plan_steps:
      return State::decide;
    case State::walk: case State::set_posture:
      return State::move;
    case State::complete: case State::bad_input: case State::spent: case State::no_reachable_view:
    case State::service_lost: case State::robot_fault: case State::aborted: case State::end:
      return State::end;
    default:
      return State::modeling;
  }
}

bool is_end(State state) { return parent(state) == State::end; }

int exit_status(State end_state) {
  switch (end_state) {
    case State::complete: return 0;
    case State::bad_input: return 2;
    case State::spent: return 3;
    case State::no_reachable_view: return 4;
    case State::service_lost: return 5;
    case State::robot_fault: return 6;
    case State::aborted: return 130;
    default: throw_error(ErrorCode::internal, std::string("not an end: ") + to_string(end_state));
  }
}

const char* to_string(State state) {
  switch (state) {
    case State::modeling: return "modeling";
    case State::observe: return "observe";
    case State::decide: return "decide";
    case State::move: return "move";
    case State::end: return "end";
    case State::prepare: return "prepare";
    case State::grab_images: return "grab_images";
    case State::set_half_sitting: return "set_half_sitting";
    case State::process_images: return "process_images";
    case State::integrate_view: return "integrate_view";
    case State::next_view: return "next_view";
    case State::generate_posture: return "generate_posture";
    case State::plan_steps: return "plan_steps";
    case State::walk: return "walk";
    case State::set_posture: return "set_posture";
    case State::return_half_sitting: return "return_half_sitting";
    case State::halt: return "halt";
    case State::complete: return "complete";
    case State::bad_input: return "bad_input";
    case State::spent: return "spent";
    case State::no_reachable_view: return "no_reachable_view";
    case State::service_lost: return "service_lost";
    case State::robot_fault: return "robot_fault";
    case State::aborted: return "aborted";
  }
  return "?";
}

const char* to_string(Trigger trigger) {
  switch (trigger) {
    case Trigger::done: return "done";
    case Trigger::failed: return "failed";
    case Trigger::refused: return "refused";
    case Trigger::view_lost: return "view_lost";
    case Trigger::perception_lost: return "perception_lost";
    case Trigger::infeasible: return "infeasible";
    case Trigger::no_path: return "no_path";
    case Trigger::gain_small: return "gain_small";
    case Trigger::converged: return "converged";
    case Trigger::budget_spent: return "budget_spent";
    case Trigger::no_view: return "no_view";
    case Trigger::lost: return "lost";
    case Trigger::abort: return "abort";
  }
  return "?";
}

State next_state(State state, Trigger trigger) {
  for (State s = state;; s = parent(s)) {
    for (const Transition& t : transitions())
      if (t.from == s && t.trigger == trigger) return t.to;
    if (s == State::modeling || s == State::end) break;
  }
  throw_error(ErrorCode::internal, std::string("the state table has no way from ") + to_string(state) + " on " + to_string(trigger));
}

std::string states_dot() {
  std::string dot = "digraph modeling {\n  rankdir=LR; compound=true; fontname=\"sans-serif\";\n"
                    "  node [shape=box style=rounded fontname=\"sans-serif\"]; edge [fontname=\"sans-serif\" fontsize=9];\n";
  for (const State super : {State::observe, State::decide, State::move, State::end}) {
    dot += std::string("  subgraph cluster_") + to_string(super) + " { label=\"" + to_string(super) + "\";";
    for (int i = static_cast<int>(State::prepare); i <= static_cast<int>(State::aborted); ++i) {
      const State s = static_cast<State>(i);
      if (parent(s) != super) continue;
      dot += std::string(" ") + to_string(s);
      if (super == State::end) dot += std::string(" [peripheries=2 label=\"") + to_string(s) + "\\nexit " + std::to_string(exit_status(s)) + "\"]";
      dot += ";";
    }
    dot += " }\n";
  }
  dot += "  modeling [label=\"anywhere\" shape=plaintext];\n";
  for (const Transition& t : transitions())
    dot += std::string("  ") + to_string(t.from) + " -> " + to_string(t.to) + " [label=\"" + to_string(t.trigger) + "\" tooltip=\"" + t.why + "\"];\n";
  return dot + "}\n";
}

}  // namespace periplus::supervisor
