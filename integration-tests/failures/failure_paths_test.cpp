// Every failure path of thesis 5.2.1 and of the state table, in the real supervisor: exit status, states entered, and what
// the robot was asked to do at the end.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>

#include "common/wire/object_wire.h"
#include "integration-tests/failures/supervised_run.h"

namespace periplus::failures {
namespace {

using namespace std::chrono_literals;

const std::string kFirstLook = "prepare grab_images set_half_sitting process_images integrate_view next_view";
const std::string kGo = " generate_posture plan_steps walk set_posture";
const std::string kLook = " grab_images set_half_sitting process_images integrate_view next_view";

class FailurePath : public testing::Test {
 protected:
  explicit FailurePath(const std::set<std::string>& absent = {})
      : name(testing::UnitTest::GetInstance()->current_test_info()->name()), run(name, absent) {}
  ~FailurePath() override {
    if (HasFailure()) std::fputs(run.bench.logs().c_str(), stderr);
  }
  // The report says the same as the last event.
  void expect_end(const RunEnd& end, int status, const std::string& says) {
    EXPECT_EQ(end.status, status) << end.reason;
    EXPECT_NE(end.reason.find(says), std::string::npos) << end.reason;
    ASSERT_FALSE(end.report.is_null());
    EXPECT_EQ(end.report.at("exit").at("status"), status);
    EXPECT_EQ(end.report.at("exit").at("reason"), end.reason);
  }

  const std::string name;
  SupervisedRun run;
};

TEST_F(FailurePath, CaptureFailsGoesBackToTheLastHalfSitting) {
  run.services.fail("vision/capture", ErrorCode::vision_images_missing, "the right image is missing", 2);
  const RunEnd end = run.run();
  expect_end(end, 6, "the right image is missing");
  EXPECT_EQ(end.trace(), kFirstLook + kGo + " grab_images return_half_sitting robot_fault");
  const auto postures = run.services.postures();
  ASSERT_EQ(postures.size(), 2u);   // to look, and back
  EXPECT_NE(postures[0], run.services.walk_end());
  EXPECT_EQ(postures[1], run.services.walk_end());
}

TEST_F(FailurePath, CaptureFailsAtOnceLeavesTheRobotWhereItStands) {
  run.services.fail("vision/capture", ErrorCode::vision_images_missing, "no camera answers");
  const RunEnd end = run.run();
  expect_end(end, 6, "no camera answers");
  EXPECT_EQ(end.trace(), "prepare grab_images return_half_sitting robot_fault");
  EXPECT_TRUE(run.services.postures().empty());   // none was recorded, so none is asked for
}

TEST_F(FailurePath, PlannerErrorEnds) {
  run.services.fail("nbv/plan", ErrorCode::internal, "the search broke");
  const RunEnd end = run.run();
  expect_end(end, 5, "the search broke");
  EXPECT_EQ(end.trace(), kFirstLook + " service_lost");
}

TEST_F(FailurePath, PlannersPoseThatIsNoNumberGoesNoFurther) {
  run.services.plan_not_a_number();
  const RunEnd end = run.run();
  expect_end(end, 5, "not_finite");
  EXPECT_EQ(end.trace(), kFirstLook + " service_lost");
  EXPECT_EQ(run.services.calls("posture/generate"), 0);
}

TEST_F(FailurePath, InfeasiblePostureIsForbiddenAndAnotherViewAskedFor) {
  run.services.fail("posture/generate", ErrorCode::posture_infeasible, "equilibrium cannot be kept", 1, 2);
  const RunEnd end = run.run("stop: {most_looks: 2}\n");
  expect_end(end, 3, "2 looks");
  EXPECT_EQ(end.trace(), kFirstLook + " generate_posture next_view generate_posture next_view" + kGo + kLook + " spent");
  const auto forbidden = run.services.forbidden();
  const auto planned = run.services.planned();
  ASSERT_EQ(forbidden.size(), 3u);
  EXPECT_TRUE(forbidden[0].empty());
  ASSERT_EQ(forbidden[2].size(), 2u);
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(forbidden[2][i].isApprox(planned[i], 1e-9)) << i;
  EXPECT_EQ(end.report.at("forbidden_poses").size(), 2u);
}

TEST_F(FailurePath, NoPathIsForbiddenAndAnotherViewAskedFor) {
  run.services.fail("walk/plan", ErrorCode::walk_no_path, "the way is barred", 1, 1);
  run.services.fail("walk/plan", ErrorCode::walk_goal_in_collision, "an obstacle stands there", 2, 2);
  const RunEnd end = run.run("stop: {most_looks: 2}\n");
  expect_end(end, 3, "2 looks");
  EXPECT_EQ(end.trace(), kFirstLook + " generate_posture plan_steps next_view generate_posture plan_steps next_view" + kGo + kLook + " spent");
  ASSERT_EQ(run.services.forbidden().size(), 3u);
  EXPECT_EQ(run.services.forbidden()[2].size(), 2u);
}

// No other view helps, and no service is to blame: the robot stays, and the model is kept.
TEST_F(FailurePath, ARobotThatCannotLeaveItsPlaceEndsWithWhatItHas) {
  run.services.fail("walk/plan", ErrorCode::walk_start_in_collision, "the half-sitting robot at the start touches the object");
  const RunEnd end = run.run();
  expect_end(end, 4, "at the start touches the object");
  EXPECT_EQ(end.trace(), kFirstLook + " generate_posture plan_steps no_reachable_view");
  EXPECT_EQ(run.services.calls("walk/plan"), 1);
  EXPECT_EQ(run.services.calls("motion/walk"), 0);
  EXPECT_TRUE(run.services.postures().empty());
  EXPECT_GT(run.services.calls("model/export"), 0);
  EXPECT_EQ(end.report.at("forbidden_poses").size(), 0u);
}

TEST_F(FailurePath, TenForbiddenPosesAtOneLookEnd) {
  run.services.fail("posture/generate", ErrorCode::posture_infeasible, "joint limits cannot be kept");
  const RunEnd end = run.run();
  expect_end(end, 4, "joint limits cannot be kept");
  EXPECT_TRUE(end.ends_with("next_view generate_posture no_reachable_view")) << end.trace();
  EXPECT_EQ(run.services.calls("posture/generate"), 10);
  EXPECT_EQ(end.report.at("forbidden_poses").size(), 10u);
}

TEST_F(FailurePath, NoReachableViewEnds) {
  run.services.fail("nbv/plan", ErrorCode::nbv_no_reachable_view, "no view satisfies the constraints");
  const RunEnd end = run.run();
  expect_end(end, 4, "no view satisfies the constraints");
  EXPECT_EQ(end.trace(), kFirstLook + " no_reachable_view");
}

TEST_F(FailurePath, NoReachableViewAfterOneThatWasReachedIsComplete) {
  run.services.fail("nbv/plan", ErrorCode::nbv_no_reachable_view, "unknown voxels are left, but no view shows one", 2);
  const RunEnd end = run.run();
  expect_end(end, 0, "unknown voxels are left");
  EXPECT_EQ(end.trace(), kFirstLook + kGo + kLook + " complete");
}

TEST_F(FailurePath, WalkFailsEndsWithoutMovingFurther) {
  run.services.fail("motion/walk", ErrorCode::motion_robot_fault, "the robot has fallen");
  const RunEnd end = run.run();
  expect_end(end, 6, "the robot has fallen");
  EXPECT_EQ(end.trace(), kFirstLook + " generate_posture plan_steps walk robot_fault");
  EXPECT_TRUE(run.services.postures().empty());
}

TEST_F(FailurePath, PostureNotReachedGoesBackToTheLastHalfSitting) {
  run.services.fail("motion/set_posture", ErrorCode::motion_joint_limit, "the left knee stopped", 1, 1);
  const RunEnd end = run.run();
  expect_end(end, 6, "the left knee stopped");
  EXPECT_EQ(end.trace(), kFirstLook + kGo + " return_half_sitting robot_fault");
  ASSERT_EQ(run.services.postures().size(), 2u);
  EXPECT_EQ(run.services.postures()[1], run.services.walk_end());
}

TEST_F(FailurePath, NotEvenHalfSittingIsReached) {
  run.services.fail("motion/set_posture", ErrorCode::motion_joint_limit, "the left knee stopped");
  const RunEnd end = run.run();
  expect_end(end, 6, "the left knee stopped");
  EXPECT_EQ(end.trace(), kFirstLook + kGo + " return_half_sitting robot_fault");
  EXPECT_EQ(run.services.calls("motion/set_posture"), 2);   // tried, and not for ever
}

TEST_F(FailurePath, ImagesWithoutDepthEnd) {
  run.services.fail("vision/process", ErrorCode::vision_no_depth, "the right eye is blank");
  const RunEnd end = run.run();
  expect_end(end, 6, "the right eye is blank");
  EXPECT_EQ(end.trace(), "prepare grab_images set_half_sitting process_images robot_fault");
}

TEST_F(FailurePath, ViewsAndPerceptionsThatWereLostAreMadeAgain) {
  run.services.fail("vision/process", ErrorCode::vision_view_unknown, "no such view", 1, 1);
  run.services.fail("model/integrate", ErrorCode::model_perception_not_here, "not here", 1, 1);
  const RunEnd end = run.run("stop: {least_gain_voxels: 1000000}\n");
  expect_end(end, 0, "less than 1000000");
  EXPECT_EQ(end.trace(),
            "prepare grab_images set_half_sitting process_images set_posture grab_images set_half_sitting process_images "
            "integrate_view process_images integrate_view next_view complete");
  EXPECT_EQ(end.report.at("looks").size(), 1u);   // taken twice, but one look
}

// Whoever was started anew has missed what the model server published.
TEST_F(FailurePath, WhatAServiceMissedIsPublishedAgainAndItIsAskedOnceMore) {
  const std::vector<std::pair<std::string, ErrorCode>> misses = {
      {"vision/capture", ErrorCode::vision_revision_not_here},     {"vision/process", ErrorCode::vision_revision_not_here},
      {"nbv/plan", ErrorCode::nbv_revision_not_here},              {"posture/generate", ErrorCode::posture_revision_not_here},
      {"walk/plan", ErrorCode::walk_revision_not_here},            {"motion/walk", ErrorCode::motion_revision_not_here},
      {"motion/set_posture", ErrorCode::motion_revision_not_here}};
  for (const auto& [rpc, code] : misses) run.services.fail(rpc, code, "not here", 1, 1);
  const RunEnd end = run.run("stop: {most_looks: 2}\n");
  expect_end(end, 3, "2 looks");
  EXPECT_EQ(end.trace(), kFirstLook + kGo + kLook + " spent");
  EXPECT_EQ(run.services.calls("model/publish"), static_cast<int>(misses.size()));
  EXPECT_EQ(run.services.environment_revisions(), std::set<std::string>{run.environment().revision().to_string()});
}

TEST_F(FailurePath, WhatIsStillMissedEndsTheRun) {
  run.services.fail("walk/plan", ErrorCode::walk_revision_not_here, "revision 1 of object thing has not arrived");
  const RunEnd end = run.run();
  expect_end(end, 5, "revision 1 of object thing has not arrived");
  EXPECT_EQ(run.services.calls("walk/plan"), 2);
}

// Two model servers, or one that came back with another store: each has but a part of the looks.
TEST_F(FailurePath, AModelInWhichEarlierLooksAreMissingEndsTheRun) {
  run.services.model_revision(0, 2);
  const RunEnd end = run.run();
  expect_end(end, 5, "revision 1 after 1");
  EXPECT_NE(end.reason.find("another model server"), std::string::npos) << end.reason;
  EXPECT_NE(end.reason.find("`periplus status`"), std::string::npos) << end.reason;
  EXPECT_EQ(end.report.at("looks").size(), 1u);
}

TEST_F(FailurePath, ARobotThatStandsElsewhereIsBadInput) {
  run.services.stand_in("triceratops", std::string(64, '0'), "");
  const RunEnd end = run.run();
  expect_end(end, 2, "triceratops");
  EXPECT_NE(end.reason.find("ball-on-table"), std::string::npos) << end.reason;
  EXPECT_NE(end.reason.find("periplus up"), std::string::npos) << end.reason;
  EXPECT_EQ(end.trace(), "prepare bad_input");
  EXPECT_EQ(run.services.calls("model/set_environment"), 0);   // what the others know is left alone
}

TEST_F(FailurePath, AnotherRobotThanTheTasksIsBadInput) {
  run.services.stand_in("ball-on-table", wire::scene_revision(harness::BallOnTable::scene_yaml()),
                        wire::robot_revision(run.bench.robot_yaml() + "# changed\n", run.bench.robot_urdf()));
  const RunEnd end = run.run();
  expect_end(end, 2, "the robot that runs is not the task's");
  EXPECT_EQ(end.trace(), "prepare bad_input");
}

TEST_F(FailurePath, ARobotInTheTasksRoomIsTaken) {
  run.services.stand_in("ball-on-table", wire::scene_revision(harness::BallOnTable::scene_yaml()),
                        wire::robot_revision(run.bench.robot_yaml(), run.bench.robot_urdf()));
  run.services.promise(1);
  EXPECT_EQ(run.run().status, 0);
}

TEST_F(FailurePath, ALossThatIsToldEndsTheRunWithItsReport) {
  run.services.hold("motion/walk");
  ASSERT_TRUE(run.start("held", run.task()).ok());
  ASSERT_TRUE(run.services.wait_for_call("motion/walk"));
  bool was_running = false;
  ASSERT_TRUE(run.abort("held", &was_running, "simulator was ended by signal 9").ok());
  EXPECT_TRUE(was_running);
  const RunEnd end = run.wait("held", 5s);
  expect_end(end, 5, "simulator was ended by signal 9");
  EXPECT_TRUE(end.ends_with("walk service_lost")) << end.trace();
  EXPECT_EQ(end.report.at("looks").size(), 1u);
  EXPECT_EQ(run.services.calls("motion/halt"), 0);
  EXPECT_EQ(run.services.calls("model/export"), 0);   // nobody is asked for anything more
}

TEST_F(FailurePath, ASupervisorThatIsKilledLeavesAReportMarkedUnfinished) {
  run.services.hold("motion/walk");
  ASSERT_TRUE(run.start("held", run.task()).ok());
  ASSERT_TRUE(run.services.wait_for_call("motion/walk"));
  run.supervisor.signal(SIGKILL);
  ASSERT_TRUE(run.supervisor.wait(5s));
  const RunEnd left = read_run(run.folder("held"));
  ASSERT_FALSE(left.report.is_null());
  EXPECT_EQ(left.report.at("exit").at("state"), "unfinished");
  EXPECT_FALSE(left.report.at("exit").contains("status"));
  EXPECT_NE(left.reason.find("walk"), std::string::npos) << left.reason;
  EXPECT_EQ(left.report.at("looks").size(), 1u);
}

TEST_F(FailurePath, ASupervisorThatIsStoppedSaysThatTheRunWasAborted) {
  run.services.hold("motion/walk");
  ASSERT_TRUE(run.start("held", run.task()).ok());
  ASSERT_TRUE(run.services.wait_for_call("motion/walk"));
  run.supervisor.signal(SIGTERM);
  const RunEnd end = run.wait("held", 5s);
  expect_end(end, 130, "the supervisor was stopped");
  EXPECT_EQ(run.services.calls("motion/halt"), 1);
  EXPECT_EQ(run.services.calls("model/export"), 0);
}

TEST_F(FailurePath, ConvergedPromisesComplete) {
  run.services.promise(5000);
  const RunEnd end = run.run("stop: {discount_looks: 0}\n");
  expect_end(end, 0, "as the last two did");
  EXPECT_EQ(end.trace(), kFirstLook + kGo + kLook + kGo + kLook + " complete");
}

// The scripted model server finds nothing of what the planner promises.
TEST_F(FailurePath, PromisesThatTheLastLooksDidNotFindComplete) {
  run.services.promise(5000);
  const RunEnd end = run.run();
  expect_end(end, 0, "(0 by what the last looks found of their promises)");
  EXPECT_EQ(end.trace(), kFirstLook + kGo + kLook + kGo + kLook + " complete");
}

TEST_F(FailurePath, ATaskThatAServiceRefusesIsBadInput) {
  run.services.fail("model/begin", ErrorCode::bad_input, "the box is larger than the room");
  const RunEnd end = run.run();
  expect_end(end, 2, "the box is larger than the room");
  EXPECT_EQ(end.trace(), "prepare bad_input");
}

TEST_F(FailurePath, AnObjectThatWasBegunOtherwiseIsBegunAnew) {
  run.services.fail("model/begin", ErrorCode::model_object_differs, "begun with another box", 1, 1);
  expect_end(run.run(), 0, "");
  EXPECT_EQ(run.services.resets(), std::vector({false, true}));
}

// Its views may be saved yet.
TEST_F(FailurePath, AStoredObjectThatCannotBeReadIsNotReplaced) {
  run.services.fail("model/begin", ErrorCode::model_store, "object thing: its state is damaged", 1, 1);
  const RunEnd end = run.run();
  expect_end(end, 5, "model_store: object thing: its state is damaged");
  EXPECT_EQ(end.trace(), "prepare service_lost");
  EXPECT_EQ(run.services.resets(), std::vector({false}));
}

TEST_F(FailurePath, AnObjectThatTheModelDoesNotKnowEnds) {
  run.services.fail("model/integrate", ErrorCode::model_object_unknown, "there is no object thing");
  const RunEnd end = run.run();
  expect_end(end, 5, "model_object_unknown: there is no object thing");
  EXPECT_TRUE(end.ends_with("integrate_view service_lost")) << end.trace();
}

TEST_F(FailurePath, ARobotThatIsSilentIsALostService) {
  run.services.fail("motion/walk", ErrorCode::motion_robot_silent, "the robot does not answer");
  const RunEnd end = run.run();
  expect_end(end, 5, "the robot does not answer");
  EXPECT_TRUE(end.ends_with("walk service_lost")) << end.trace();
}

class WithoutPlanner : public FailurePath {
 protected:
  WithoutPlanner() : FailurePath({"nbv/plan"}) {}
};

TEST_F(WithoutPlanner, ANeverOfferedServiceIsALostOneWithinTenSeconds) {
  const auto began = std::chrono::steady_clock::now();
  const RunEnd end = run.run();
  EXPECT_LT(std::chrono::steady_clock::now() - began, 15s);   // with the start of the supervisor
  expect_end(end, 5, "nbv/plan");
  EXPECT_EQ(end.trace(), kFirstLook + " service_lost");
}

TEST_F(FailurePath, AbortWhileWalkingHaltsTheRobot) {
  run.services.hold("motion/walk");
  ASSERT_TRUE(run.start("held", run.task()).ok());
  ASSERT_TRUE(run.services.wait_for_call("motion/walk"));
  // Only the run that is there can be aborted.
  const dds::RpcResult other = run.abort("another");
  EXPECT_EQ(other.error_code, static_cast<int>(ErrorCode::supervisor_no_such_run));
  EXPECT_NE(other.error_message.find("periplus watch"), std::string::npos) << other.error_message;
  // And no other begun; the same one asked for again is the same one.
  const dds::RpcResult second = run.start("second", run.task());
  EXPECT_EQ(second.error_code, static_cast<int>(ErrorCode::supervisor_busy));
  EXPECT_NE(second.error_message.find("periplus abort"), std::string::npos) << second.error_message;
  std::string folder;
  EXPECT_TRUE(run.start("held", run.task(), &folder).ok());
  EXPECT_EQ(folder, run.bench.folder() + "/runs/held");

  bool was_running = false;
  ASSERT_TRUE(run.abort("held", &was_running).ok());
  EXPECT_TRUE(was_running);
  const RunEnd end = run.wait("held");
  expect_end(end, 130, "aborted by the user");
  EXPECT_TRUE(end.ends_with("walk halt aborted")) << end.trace();
  EXPECT_EQ(run.services.calls("motion/halt"), 1);
  EXPECT_TRUE(run.services.postures().empty());
  // Nothing hangs: with nothing under way abort says so.
  ASSERT_TRUE(run.abort("", &was_running).ok());
  EXPECT_FALSE(was_running);
}

TEST_F(FailurePath, AbortIsHeardWhereTheRobotCannotHalt) {
  run.services.hold("nbv/plan");
  run.services.fail("motion/halt", ErrorCode::motion_robot_silent, "the robot does not answer");
  ASSERT_TRUE(run.start("held", run.task()).ok());
  ASSERT_TRUE(run.services.wait_for_call("nbv/plan"));
  ASSERT_TRUE(run.abort("").ok());
  const RunEnd end = run.wait("held");
  expect_end(end, 130, "aborted by the user");
  EXPECT_TRUE(end.ends_with("next_view halt aborted")) << end.trace();
}

TEST_F(FailurePath, TasksFromTheBusAreCheckedLikeFiles) {
  const auto refusal = [this](const std::string& text) {
    const dds::RpcResult result = run.start("bad", text);
    EXPECT_EQ(result.error_code, static_cast<int>(ErrorCode::supervisor_bad_task)) << text;
    return result.error_message;
  };
  EXPECT_NE(refusal(run.task("stpo: {most_looks: 2}\n")).find("stop"), std::string::npos);
  EXPECT_NE(refusal("schema: [1\n").find("task:"), std::string::npos);
  EXPECT_NE(refusal("").find("schema"), std::string::npos);
  // A run's name becomes a folder: it must not lead elsewhere.
  const dds::RpcResult result = run.start("../elsewhere", run.task());
  EXPECT_EQ(result.error_code, static_cast<int>(ErrorCode::bad_input)) << result.error_message;
  // But the files that it names stand on the client's computer: here they need not exist.
  std::string elsewhere = run.task();
  for (const std::string file : {"hrp2like.yaml", "bunny.yaml"}) elsewhere.replace(elsewhere.find(file), file.size(), "not-here-" + file);
  run.services.promise(1);
  ASSERT_TRUE(run.start("from-afar", elsewhere).ok());
  EXPECT_EQ(run.wait("from-afar").status, 0);
  // And after all that the supervisor still works.
  EXPECT_EQ(run.run().status, 0);
}

}  // namespace
}  // namespace periplus::failures
