#include "common/dds/call_window.h"

#include <gtest/gtest.h>

namespace periplus::dds::detail {
namespace {

using namespace std::chrono_literals;

std::shared_ptr<Call> make_call(std::uint8_t client, std::int64_t number, std::size_t bytes = 100) {
  auto call = std::make_shared<Call>();
  call->name.client.fill(client);
  call->name.number = number;
  call->reply_bytes = bytes;
  return call;
}

class CallWindowTest : public ::testing::Test {
 protected:
  std::shared_ptr<Call> run(std::uint8_t client, std::int64_t number, std::size_t bytes = 100) {
    auto call = make_call(client, number, bytes);
    window.add(call, now);
    window.finish(call);
    return call;
  }
  bool known(std::uint8_t client, std::int64_t number) { return window.find(make_call(client, number)->name, now) != nullptr; }

  CallWindow window{{.threads = 1, .window = 4, .expiry = 120s}};
  CallWindow::Time now{};
};

TEST_F(CallWindowTest, RemembersRunningAndFinishedCallsOfEachClientApart) {
  const auto running = make_call(1, 7);
  window.add(running, now);
  EXPECT_EQ(window.find(running->name, now), running);
  EXPECT_FALSE(known(2, 7));
  EXPECT_FALSE(known(1, 8));
  window.finish(running);
  EXPECT_TRUE(known(1, 7));
  EXPECT_TRUE(running->done);
}

TEST_F(CallWindowTest, ForgetsTheOldestRepliesButNeverWhatRuns) {
  const auto running = make_call(1, 1);
  window.add(running, now);
  for (int i = 2; i <= 10; ++i) run(1, i);
  EXPECT_TRUE(known(1, 1));
  EXPECT_FALSE(known(1, 6));
  EXPECT_TRUE(known(1, 7));
  EXPECT_TRUE(known(1, 10));
  EXPECT_EQ(window.replies(), 4U);
}

TEST_F(CallWindowTest, LargeRepliesAreBoundedByBytesAndTheNewestStays) {
  run(1, 1, 40U << 20);
  run(1, 2, 40U << 20);
  EXPECT_FALSE(known(1, 1));
  EXPECT_TRUE(known(1, 2));
  run(1, 3, 200U << 20);
  EXPECT_TRUE(known(1, 3));
}

TEST_F(CallWindowTest, SilentClientExpiresUnlessSomethingRuns) {
  run(1, 1);
  window.add(make_call(2, 1), now);
  now += 60s;
  EXPECT_TRUE(known(1, 1));  // a sign of life
  now += 119s;
  window.expire(now);
  EXPECT_EQ(window.clients(), 2U);
  now += 2s;
  window.expire(now);
  EXPECT_EQ(window.clients(), 1U);
  EXPECT_TRUE(known(2, 1));
}

TEST_F(CallWindowTest, CancelAllTellsOnlyThoseThatRun) {
  const auto done = run(1, 1), running = make_call(1, 2);
  window.add(running, now);
  window.cancel_all();
  EXPECT_FALSE(done->cancelled);
  EXPECT_TRUE(running->cancelled);
}

}  // namespace
}  // namespace periplus::dds::detail
