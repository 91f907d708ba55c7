#include "services/motion_controller/motion_memory.h"

#include <gtest/gtest.h>

#include <thread>

namespace periplus::motion {
namespace {

ErrorCode refusal(MotionMemory& memory, const std::string& id, const std::string& content) {
  try {
    memory.begin(id, content);
  } catch (const Error& e) {
    return e.code();
  }
  return ErrorCode::ok;
}

TEST(MotionMemory, AnswersAlikeWithoutMovingAgain) {
  MotionMemory memory;
  EXPECT_FALSE(memory.begin("m1", "walk").has_value());
  MotionResult result;
  result.ticks = 77;
  result.error = ErrorCode::motion_halted;
  memory.finish(result);
  const auto again = memory.begin("m1", "walk");
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->ticks, 77u);
  EXPECT_EQ(again->error, ErrorCode::motion_halted);
  EXPECT_EQ(refusal(memory, "m1", "another walk"), ErrorCode::bad_input);
}

TEST(MotionMemory, WhatFailedMayBeTriedAgain) {
  MotionMemory memory;
  memory.begin("m1", "walk");
  MotionResult refused;
  refused.error = ErrorCode::model_environment_missing;
  memory.finish(refused);
  EXPECT_FALSE(memory.begin("m1", "walk").has_value());
}

TEST(MotionMemory, OneMotionAtATime) {
  MotionMemory memory;
  memory.begin("m1", "walk");
  EXPECT_EQ(refusal(memory, "m2", "walk"), ErrorCode::motion_busy);
  memory.finish({});
  EXPECT_EQ(refusal(memory, "m2", "walk"), ErrorCode::ok);
}

TEST(MotionMemory, WhoAsksMeanwhileWaitsForTheResult) {
  MotionMemory memory;
  memory.begin("m1", "walk");
  std::optional<MotionResult> second;
  std::thread asks([&] { second = memory.begin("m1", "walk"); });
  MotionResult result;
  result.ticks = 5;
  memory.finish(result);
  asks.join();
  ASSERT_TRUE(second.has_value());
  EXPECT_EQ(second->ticks, 5u);
}

TEST(MotionMemory, HaltsOnlyTheMotionUnderWay) {
  MotionMemory memory;
  EXPECT_FALSE(memory.ask_to_halt());
  EXPECT_TRUE(memory.wait_until_still(0.01));
  memory.begin("m1", "walk");
  EXPECT_FALSE(memory.halt_asked());
  EXPECT_TRUE(memory.ask_to_halt());
  EXPECT_TRUE(memory.halt_asked());
  EXPECT_FALSE(memory.wait_until_still(0.01));
  memory.finish({});
  EXPECT_TRUE(memory.wait_until_still(0.01));
  memory.begin("m2", "walk");
  EXPECT_FALSE(memory.halt_asked());
  memory.finish({});
}

TEST(MotionMemory, ForgetsTheOldest) {
  MotionMemory memory(2);
  for (const char* id : {"m1", "m2", "m3"}) {
    memory.begin(id, "walk");
    memory.finish({});
  }
  EXPECT_TRUE(memory.begin("m2", "walk").has_value());
  EXPECT_FALSE(memory.begin("m1", "walk").has_value());
}

}  // namespace
}  // namespace periplus::motion
