// The client against a server of the same process; what happens between processes stands in vendor_pairs_test.cpp.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/dds/testing/test_domain.h"
#include "idl/model.h"

namespace periplus::dds {
namespace {

using namespace std::chrono_literals;
using Client = RpcClient<msg::ExportRequest, msg::ExportReply>;
using Server = RpcServer<msg::ExportRequest, msg::ExportReply>;
using Clock = std::chrono::steady_clock;

class RpcClientTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    NodeOptions options;
    options.vendor = GetParam();
    options.domain = domain_.id();
    node_ = Node::create(options);
  }
  testing::TestDomain domain_;
  std::shared_ptr<Node> node_;
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

INSTANTIATE_TEST_SUITE_P(, RpcClientTest, ::testing::Values("fastdds", "cyclonedds"));

}  // namespace
}  // namespace periplus::dds
