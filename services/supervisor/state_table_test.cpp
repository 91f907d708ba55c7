#include "services/supervisor/state_table.h"

#include <gtest/gtest.h>

#include <set>

#include "common/core/error.h"

namespace periplus::supervisor {
namespace {

TEST(StateTable, FailurePathsOfThesis521) {
  EXPECT_EQ(next_state(State::grab_images, Trigger::failed), State::return_half_sitting);
  EXPECT_EQ(next_state(State::next_view, Trigger::failed), State::service_lost);
  EXPECT_EQ(next_state(State::generate_posture, Trigger::infeasible), State::next_view);
  EXPECT_EQ(next_state(State::plan_steps, Trigger::no_path), State::next_view);
  EXPECT_EQ(next_state(State::walk, Trigger::failed), State::robot_fault);
  EXPECT_EQ(next_state(State::set_posture, Trigger::failed), State::return_half_sitting);
}

TEST(StateTable, SuperstateRowsHoldEverywhereButWhereAStateHasItsOwn) {
  EXPECT_EQ(next_state(State::walk, Trigger::lost), State::service_lost);
  EXPECT_EQ(next_state(State::prepare, Trigger::abort), State::halt);
  EXPECT_EQ(next_state(State::halt, Trigger::lost), State::aborted);
  EXPECT_THROW(next_state(State::walk, Trigger::converged), Error);
}

TEST(StateTable, NoStateIsADeadEndAndNoRowStandsTwice) {
  std::set<std::pair<State, Trigger>> seen;
  for (const Transition& t : transitions()) {
    EXPECT_TRUE(seen.insert({t.from, t.trigger}).second) << to_string(t.from) << " " << to_string(t.trigger);
    EXPECT_FALSE(is_end(t.from));
  }
  for (int i = static_cast<int>(State::prepare); i <= static_cast<int>(State::halt); ++i) {
    const State s = static_cast<State>(i);
    EXPECT_NO_THROW(next_state(s, Trigger::done)) << to_string(s);
    EXPECT_NO_THROW(next_state(s, Trigger::failed)) << to_string(s);
  }
  // Every end can be reached from the start.
  std::set<State> reached{State::prepare}, open{State::prepare, State::halt, State::service_lost};
  while (!open.empty()) {
    const State s = *open.begin();
    open.erase(open.begin());
    reached.insert(s);
    for (const Transition& t : transitions())
      if (t.from == s && !reached.count(t.to)) open.insert(t.to);
  }
  for (int i = static_cast<int>(State::complete); i <= static_cast<int>(State::aborted); ++i)
    EXPECT_TRUE(reached.count(static_cast<State>(i))) << to_string(static_cast<State>(i));
}

TEST(StateTable, DrawingNamesEveryState) {
  const std::string dot = states_dot();
  for (const Transition& t : transitions()) {
    EXPECT_NE(dot.find(to_string(t.from)), std::string::npos);
    EXPECT_NE(dot.find(to_string(t.to)), std::string::npos);
  }
}

}  // namespace
}  // namespace periplus::supervisor
