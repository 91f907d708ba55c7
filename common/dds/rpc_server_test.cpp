#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <thread>

#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/dds/testing/eventually.h"
#include "common/dds/testing/vendor_test.h"
#include "idl/model.h"

namespace periplus::dds {
namespace {

using namespace std::chrono_literals;
using Client = RpcClient<msg::ExportRequest, msg::ExportReply>;
using Server = RpcServer<msg::ExportRequest, msg::ExportReply>;

class RpcServerTest : public testing::VendorTest {
 protected:
  const std::shared_ptr<Node> node_ = node();
};

TEST_P(RpcServerTest, ErrorsReachTheCallerWithoutHalfMadeReplies) {
  Server server(*node_, "a", [](const msg::ExportRequest& q, msg::ExportReply& r, RpcContext&) {
    r.revision(99);
    if (q.format().to_string() == "refuse") throw Error(ErrorCode::bad_input, "give another format");
    throw std::runtime_error("oops");
  });
  Client client(*node_, "a");
  msg::ExportRequest q;
  msg::ExportReply r;
  q.format("refuse");
  auto result = client.call(q, r, {.deadline = 10s, .wait_for_server = 10s});
  EXPECT_EQ(result.status, RpcStatus::ok);
  EXPECT_EQ(result.error_code, static_cast<int>(ErrorCode::bad_input));
  EXPECT_EQ(result.error_message, "give another format");
  EXPECT_EQ(r.revision(), 0U);
  q.format("x");
  result = client.call(q, r);
  EXPECT_EQ(result.error_code, static_cast<int>(ErrorCode::internal));
  EXPECT_EQ(server.statistics().errors, 2U);
}

TEST_P(RpcServerTest, CountsCallsAndLatencies) {
  Server server(*node_, "a", [](const auto&, auto&, RpcContext&) { std::this_thread::sleep_for(10ms); });
  Client client(*node_, "a");
  msg::ExportRequest q;
  msg::ExportReply r;
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(client.call(q, r, {.deadline = 10s, .wait_for_server = 10s}).ok());
  const auto s = server.statistics();
  EXPECT_EQ(s.name, "a");
  EXPECT_EQ(s.calls, 5U);
  EXPECT_EQ(s.errors, 0U);
  EXPECT_GE(s.p50_ms, 10.0);
  EXPECT_GE(s.p99_ms, s.p50_ms);
}

TEST_P(RpcServerTest, AsManyHandlersRunAtOnceAsThereAreThreads) {
  std::atomic<int> running{0}, most{0};
  Server server(
      *node_, "a",
      [&](const auto&, auto&, RpcContext&) {
        const int now = ++running;
        int seen = most;
        while (now > seen && !most.compare_exchange_weak(seen, now)) {}
        std::this_thread::sleep_for(100ms);
        --running;
      },
      {.threads = 3});
  Client client(*node_, "a");
  ASSERT_TRUE(client.wait_for_server(10s));
  std::vector<std::future<bool>> calls;
  for (int i = 0; i < 6; ++i) {
    calls.push_back(std::async(std::launch::async, [&] {
      msg::ExportRequest q;
      msg::ExportReply r;
      return client.call(q, r, {.deadline = 10s}).ok();
    }));
  }
  for (auto& call : calls) EXPECT_TRUE(call.get());
  EXPECT_EQ(most, 3);
}

TEST_P(RpcServerTest, ACallOfAnotherInstanceIsNotRun) {
  std::atomic<int> runs{0};
  Server server(*node_, "a", [&](const auto&, auto&, RpcContext&) { ++runs; });
  const auto requests = node_->writer("rq/a", codec<msg::ExportRequest>(), qos_rpc());
  for (int i = 0; i < 500 && requests->matched_count() == 0; ++i) std::this_thread::sleep_for(10ms);
  msg::ExportRequest q;
  auto server_guid = q.header().server().value();
  server_guid.fill(9);
  q.header().server().value(server_guid);
  q.header().number(1);
  requests->write(&q);
  q.header().server().value({});
  q.header().number(2);
  requests->write(&q);  // for any instance
  for (int i = 0; i < 500 && runs == 0; ++i) std::this_thread::sleep_for(10ms);
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(runs, 1);
}

// The caller takes it for lost and asks another instance, instead of being told that it cancelled.
TEST_P(RpcServerTest, ServerThatLeavesDoesNotAnswerWhatItCutShort) {
  std::atomic<int> answers{0}, running{0};
  ReaderThread replies(*node_, "rr/a", codec<msg::ExportReply>(), qos_rpc(), [&](const void* sample) {
    if (static_cast<const msg::ExportReply*>(sample)->header().number() > 0) ++answers;
  });
  const auto requests = node_->writer("rq/a", codec<msg::ExportRequest>(), qos_rpc());
  for (int round = 1; round <= 15; ++round) {
    auto server = std::make_unique<Server>(*node_, "a", [&](const auto&, auto&, RpcContext& context) {
      ++running;
      while (!context.cancelled()) std::this_thread::yield();
    });
    ASSERT_TRUE(testing::eventually([&] { return requests->matched_count() == 1 && replies.reader().alive_writers() == 1; }));
    msg::ExportRequest q;
    q.header().client().value(replies.reader().guid());
    q.header().number(round);
    requests->write(&q);
    ASSERT_TRUE(testing::eventually([&] { return running == round; }));
    server.reset();
    ASSERT_TRUE(testing::eventually([&] { return requests->matched_count() == 0; }));
  }
  EXPECT_EQ(answers, 0);
}

INSTANTIATE_TEST_SUITE_P(, RpcServerTest, testing::each_vendor());

}  // namespace
}  // namespace periplus::dds
