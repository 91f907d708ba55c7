// The client against a server of the same process; what happens between processes stands in vendor_pairs_test.cpp.
#include <gtest/gtest.h>

#include <atomic>
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
using Clock = std::chrono::steady_clock;

class RpcClientTest : public testing::VendorTest {
 protected:
  const std::shared_ptr<Node> node_ = node();
};

TEST_P(RpcClientTest, SaysNoServerAtOnceAndWaitsWhenAsked) {
  Client client(*node_, "a");
  msg::ExportRequest q;
  msg::ExportReply r;
  auto begin = Clock::now();
  EXPECT_EQ(client.call(q, r).status, RpcStatus::no_server);
  EXPECT_LT(Clock::now() - begin, 200ms);
  EXPECT_FALSE(client.wait_for_server(20ms));
  begin = Clock::now();
  EXPECT_EQ(client.call(q, r, {.deadline = 5s, .wait_for_server = 300ms}).status, RpcStatus::no_server);
  EXPECT_GE(Clock::now() - begin, 300ms);
  EXPECT_EQ(client.call(q, r, {.deadline = 100ms, .wait_for_server = 10s}).status, RpcStatus::timeout) << "the deadline holds for the waiting too";
}

TEST_P(RpcClientTest, WaitsForAServerThatComesLater) {
  Client client(*node_, "a");
  std::unique_ptr<Server> server;
  std::thread later([&] {
    std::this_thread::sleep_for(300ms);
    server = std::make_unique<Server>(*node_, "a", [](const auto&, auto& reply, RpcContext&) { reply.revision(3); });
  });
  msg::ExportRequest q;
  msg::ExportReply r;
  EXPECT_TRUE(client.call(q, r, {.deadline = 10s, .wait_for_server = 10s}).ok());
  EXPECT_EQ(r.revision(), 3U);
  later.join();
  EXPECT_EQ(client.servers(), 1);
}

TEST_P(RpcClientTest, CancelWithoutServersConfirmationEndsAfterASecond) {
  std::atomic<bool> release{false};
  Client client(*node_, "a");
  Server server(*node_, "a", [&](const auto&, auto&, RpcContext&) {
    while (!release) std::this_thread::sleep_for(5ms);
  });
  ASSERT_TRUE(client.wait_for_server(10s));
  msg::ExportRequest q;
  msg::ExportReply r;
  const auto begin = Clock::now();
  EXPECT_EQ(client.call(q, r, {.deadline = 10s, .cancelled = [&] { return Clock::now() - begin > 100ms; }}).status, RpcStatus::cancelled);
  EXPECT_GE(Clock::now() - begin, 1s);
  EXPECT_LT(Clock::now() - begin, 2s);
  release = true;
}

TEST_P(RpcClientTest, ServerThatLeavesIsLostAtOnce) {
  Client client(*node_, "a");
  auto server = std::make_unique<Server>(*node_, "a", [&](const auto&, auto&, RpcContext& context) {
    while (!context.cancelled()) std::this_thread::sleep_for(5ms);
  });
  ASSERT_TRUE(client.wait_for_server(10s));
  std::thread leaves([&] {
    std::this_thread::sleep_for(300ms);
    server.reset();
  });
  msg::ExportRequest q;
  msg::ExportReply r;
  const auto begin = Clock::now();
  EXPECT_EQ(client.call(q, r, {.deadline = 10s}).status, RpcStatus::server_lost);
  EXPECT_LT(Clock::now() - begin, 1500ms);
  leaves.join();
}

TEST_P(RpcClientTest, CallLeftByAnExceptionOfTheCallersIsForgotten) {
  Client client(*node_, "a");
  std::atomic<int> answered{0};
  const auto handler = [&](const auto& request, auto& reply, RpcContext&) {
    if (request.format().to_string() == "slow") std::this_thread::sleep_for(300ms);
    reply.revision(5);
    ++answered;
  };
  const auto one = node(), two = node();
  const Server first(*one, "a", handler), second(*two, "a", handler);
  ASSERT_TRUE(testing::eventually([&] { return client.servers() == 2; }));
  msg::ExportRequest q;
  msg::ExportReply r;
  int asked = 0;
  const auto leave = [&]() -> bool {
    if (++asked > 1) throw std::runtime_error("enough");  // the first time is before the request goes out
    return false;
  };
  q.format("slow");
  EXPECT_THROW(client.call(q, r, {.deadline = 10s, .cancelled = leave}), std::runtime_error);
  q.format("");
  ASSERT_TRUE(testing::eventually([&] { return answered == 1; }));
  std::this_thread::sleep_for(200ms);
  EXPECT_EQ(r.revision(), 0U) << "a reply was written to a caller that had left";
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(client.call(q, r, {.deadline = 10s}).ok());
  EXPECT_GE(first.statistics().calls, 5U) << "the call that was left still counts as a load";
  EXPECT_GE(second.statistics().calls, 5U);
}

TEST_P(RpcClientTest, ACallMayBeBoundToOneOfTheOthers) {
  Client client(*node_, "a");
  const auto handler = [](std::uint32_t number) {
    return [number](const auto&, auto& reply, RpcContext& context) {
      while (number == 2 && !context.cancelled()) std::this_thread::sleep_for(5ms);
      reply.revision(number);
    };
  };
  const auto one = node(), two = node();
  const Server own(*node_, "a", handler(0)), first(*one, "a", handler(1));
  auto second = std::make_unique<Server>(*two, "a", handler(2));
  ASSERT_TRUE(testing::eventually([&] { return client.servers() == 3; }));
  const std::vector<Guid> others = client.others();
  ASSERT_EQ(others.size(), 2U) << "the own instance is not among the others";
  msg::ExportRequest q;
  msg::ExportReply r;
  std::optional<Guid> quick, slow;
  for (const Guid& other : others) {
    for (int i = 0; i < 3; ++i) {
      const RpcResult result = client.call(q, r, {.deadline = 300ms, .only_on = other});
      if (result.status == RpcStatus::timeout) slow = other;
      if (result.ok()) {
        quick = other;
        EXPECT_EQ(r.revision(), 1U);
      }
    }
  }
  ASSERT_TRUE(quick && slow && quick != slow);
  EXPECT_EQ(own.statistics().calls, 0U);
  std::thread leaves([&] {
    std::this_thread::sleep_for(300ms);
    second.reset();
  });
  EXPECT_EQ(client.call(q, r, {.deadline = 10s, .only_on = slow}).status, RpcStatus::server_lost) << "no other may take over";
  leaves.join();
  EXPECT_EQ(client.others(), std::vector<Guid>{*quick});
}

INSTANTIATE_TEST_SUITE_P(, RpcClientTest, testing::each_vendor());

}  // namespace
}  // namespace periplus::dds
