#include "services/supervisor/modeling_machine.h"

#include <gtest/gtest.h>

#include <map>

namespace periplus::supervisor {
namespace {

// Does each state's next scripted outcome, `done` where none is left; completes after `looks` looks.
class Scripted : public Actions {
 public:
  std::map<State, std::vector<Outcome>> script;
  int looks = 2;
  std::optional<Outcome> interrupted;
  Outcome interruption_to_come{Trigger::abort, "aborted by the user"};
  State interrupted_at = State::end;

  Outcome perform(State state) override {
    if (state == interrupted_at) interrupted = interruption_to_come;
    auto& left = script[state];
    if (!left.empty()) {
      const Outcome o = left.front();
      left.erase(left.begin());
      return o;
    }
    if (state == State::next_view && ++seen_ > looks) return {Trigger::gain_small, "nothing left"};
    return {};
  }
  std::optional<Outcome> interruption() const override { return interrupted; }

 private:
  int seen_ = 0;
};

std::pair<MachineResult, std::string> run(Scripted& actions) {
  std::string trace;
  const MachineResult result = run_machine(actions, [&](State s, const std::string&) { trace += std::string(to_string(s)) + " "; });
  return {result, trace};
}

TEST(ModelingMachine, OneTurnOfTheLoop) {
  Scripted a;
  a.looks = 1;
  const auto [result, trace] = run(a);
  EXPECT_EQ(trace,
            "prepare grab_images set_half_sitting process_images integrate_view next_view generate_posture plan_steps walk "
            "set_posture grab_images set_half_sitting process_images integrate_view next_view complete ");
  EXPECT_EQ(exit_status(result.end), 0);
  EXPECT_EQ(result.cause, "nothing left");
}

TEST(ModelingMachine, CaptureFailureReturnsToHalfSittingAndKeepsItsCause) {
  Scripted a;
  a.script[State::grab_images] = {{Trigger::failed, "no images from the right camera"}};
  const auto [result, trace] = run(a);
  EXPECT_EQ(trace, "prepare grab_images return_half_sitting robot_fault ");
  EXPECT_EQ(exit_status(result.end), 6);
  EXPECT_EQ(result.cause, "no images from the right camera");
}

TEST(ModelingMachine, InfeasiblePostureAndMissingPathAskForAnotherView) {
  Scripted a;
  a.looks = 3;
  a.script[State::generate_posture] = {{Trigger::infeasible, "knee"}};
  a.script[State::plan_steps] = {{Trigger::no_path, "wall"}};
  const auto [result, trace] = run(a);
  EXPECT_NE(trace.find("generate_posture next_view generate_posture plan_steps next_view generate_posture plan_steps walk"), std::string::npos) << trace;
  EXPECT_EQ(result.end, State::complete);
}

TEST(ModelingMachine, AbortHaltsTheRobotFromAnyState) {
  for (const State at : {State::prepare, State::process_images, State::next_view, State::walk, State::set_posture}) {
    Scripted a;
    a.interrupted_at = at;
    const auto [result, trace] = run(a);
    EXPECT_EQ(exit_status(result.end), 130);
    EXPECT_NE(trace.find("halt aborted"), std::string::npos) << trace;
    EXPECT_EQ(result.cause, "aborted by the user");
  }
}

TEST(ModelingMachine, ALossThatIsToldEndsTheRunAtOnce) {
  Scripted a;
  a.interrupted_at = State::plan_steps;
  a.interruption_to_come = {Trigger::lost, "simulator was ended by signal 9"};
  const auto [result, trace] = run(a);
  EXPECT_EQ(exit_status(result.end), 5);
  EXPECT_EQ(result.cause, "simulator was ended by signal 9");
  EXPECT_NE(trace.find("plan_steps walk service_lost"), std::string::npos) << trace;   // found before the walk begins
}

TEST(ModelingMachine, ALostServiceEndsTheRun) {
  Scripted a;
  a.script[State::walk] = {{Trigger::lost, "motion_controller"}};
  EXPECT_EQ(exit_status(run(a).first.end), 5);
}

TEST(StopRule, LeastGainAndConvergenceByTheLastTwoScores) {
  StopRule rule({.least_gain_voxels = 20, .variation_voxels = 5, .most_looks = 9, .most_time_s = 1});
  EXPECT_EQ(rule.judge(1, 500), Trigger::done);
  EXPECT_EQ(rule.judge(2, 100), Trigger::done);
  EXPECT_EQ(rule.judge(2, 102), Trigger::done);  // forbidden, planned again: replaces
  EXPECT_EQ(rule.judge(3, 100), Trigger::done);
  EXPECT_EQ(rule.judge(4, 99), Trigger::converged);
  EXPECT_EQ(rule.judge(5, 19), Trigger::gain_small);
  StopRule off({.least_gain_voxels = 1, .variation_voxels = 0, .most_looks = 9, .most_time_s = 1});
  for (int i = 0; i < 5; ++i) EXPECT_EQ(off.judge(i, 50), Trigger::done);
}

TEST(StopRule, PromisesCountByWhatTheLastLooksFoundOfTheirs) {
  StopRule rule({.least_gain_voxels = 100, .discount_looks = 2, .variation_voxels = 0, .most_looks = 9, .most_time_s = 1});
  rule.looked(-1, 50000);  // the first look is not planned
  rule.looked(1000, 2000);
  EXPECT_EQ(rule.trust(), 1);  // of one look alone nothing is concluded
  rule.looked(600, 0);
  EXPECT_EQ(rule.trust(), 1);  // 2000 of 1600
  rule.looked(600, 150);
  EXPECT_DOUBLE_EQ(rule.trust(), 0.125);
  EXPECT_EQ(rule.judge(4, 800), Trigger::done);
  EXPECT_EQ(rule.judge(4, 799), Trigger::gain_small);
  rule.looked(400, -20);  // voxels may become unknown again
  rule.looked(400, -20);
  EXPECT_EQ(rule.trust(), 0);
  StopRule off({.least_gain_voxels = 100, .discount_looks = 0, .variation_voxels = 0, .most_looks = 9, .most_time_s = 1});
  off.looked(600, 0);
  off.looked(600, 0);
  EXPECT_EQ(off.judge(3, 101), Trigger::done);
}

}  // namespace
}  // namespace periplus::supervisor
