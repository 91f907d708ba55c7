// Each pair of vendors on two networks whose connection goes away and comes back.
#include <atomic>
#include <thread>

#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/dds/testing/eventually.h"
#include "common/dds/testing/network_namespace.h"
#include "common/dds/testing/vendor_test.h"
#include "idl/common.h"
#include "idl/model.h"

namespace periplus::dds {
namespace {

using namespace std::chrono_literals;
using testing::eventually;

using testing::NetworkPair;

class NetworkCut : public testing::VendorPairTest {
 protected:
  NetworkCut() {
    lease_ = 2000ms;
    options_.interface = NetworkPair::near_interface;
    options_.peers = {NetworkPair::far_address};
    options_.shared_memory = false;
    environment_ = {std::string("PERIPLUS_INTERFACE=") + NetworkPair::far_interface, std::string("PERIPLUS_PEERS=") + NetworkPair::near_address,
                    "PERIPLUS_SHM=0"};
  }
  // Listens to the peer "beat", which tells how often it joined anew.
  struct Listener {
    explicit Listener(Node& node)
        : client(node, "test/beat"), in(node, "beat", qos_stream(1), [this](const msg::ServiceStatus& s) {
            rejoins_of_peer = s.bad_samples();
            ++beats;
          }) {}
    bool answered() {
      msg::ExportRequest request;
      msg::ExportReply reply;
      request.format("there?");
      return client.call(request, reply, {.deadline = 5s, .wait_for_server = 5s}).ok() && reply.sha256().to_string() == "there?";
    }
    std::atomic<int> beats{0};
    std::atomic<std::uint64_t> rejoins_of_peer{0};
    RpcClient<msg::ExportRequest, msg::ExportReply> client;
    Subscriber<msg::ServiceStatus> in;
  };
};

TEST_P(NetworkCut, LongerThanTheLeaseEndsWithBothSidesHearingEachOtherAgain) {
  const bool permitted = NetworkPair::run([&](NetworkPair& networks) {
    const auto other = networks.on_far_side([&] { return peer("beat"); });
    const auto self = node();
    Listener listener(*self);
    ASSERT_TRUE(eventually([&] { return listener.beats > 0 && listener.client.servers() == 1; }));
    networks.set_link(false);
    EXPECT_TRUE(eventually([&] { return listener.in.matched() == 0; })) << "the lease did not end";
    std::this_thread::sleep_for(1s);
    const int before = listener.beats;
    networks.set_link(true);
    EXPECT_TRUE(eventually([&] { return listener.beats > before + 20 && listener.rejoins_of_peer >= 1; }))
        << listener.beats - before << " beats, the peer joined anew " << listener.rejoins_of_peer << " times";
    EXPECT_GE(self->rejoins(), 1U);
    EXPECT_TRUE(listener.answered());
  });
  if (!permitted) GTEST_SKIP() << "needs root, to make network namespaces";
}

// As behind a switch that fails: neither side's interface tells.
TEST_P(NetworkCut, ThatNoInterfaceTellsIsGotOverToo) {
  const bool permitted = NetworkPair::run([&](NetworkPair& networks) {
    const auto other = networks.on_far_side([&] { return peer("beat"); });
    const auto self = node();
    Listener listener(*self);
    ASSERT_TRUE(eventually([&] { return listener.beats > 0 && listener.client.servers() == 1; }));
    networks.set_silent(true);
    EXPECT_TRUE(eventually([&] { return listener.in.matched() == 0; })) << "the lease did not end";
    std::this_thread::sleep_for(3s);  // the peer's lease of us too
    const int before = listener.beats;
    networks.set_silent(false);
    EXPECT_TRUE(eventually([&] { return listener.beats > before + 20; })) << listener.beats - before << " beats";
    EXPECT_TRUE(listener.answered());
  });
  if (!permitted) GTEST_SKIP() << "needs root, to make network namespaces";
}

TEST_P(NetworkCut, ShorterThanTheLeaseNeedsNoJoiningAnew) {
  lease_ = 20000ms;
  const bool permitted = NetworkPair::run([&](NetworkPair& networks) {
    const auto other = networks.on_far_side([&] { return peer("beat"); });
    const auto self = node();
    Listener listener(*self);
    ASSERT_TRUE(eventually([&] { return listener.beats > 0 && listener.client.servers() == 1; }));
    networks.set_link(false);
    std::this_thread::sleep_for(1500ms);
    const int before = listener.beats;
    networks.set_link(true);
    EXPECT_TRUE(eventually([&] { return listener.beats > before + 20; })) << listener.beats - before << " beats";
    EXPECT_TRUE(listener.answered());
    EXPECT_EQ(self->rejoins() + listener.rejoins_of_peer, 0U);
  });
  if (!permitted) GTEST_SKIP() << "needs root, to make network namespaces";
}

TEST_P(NetworkCut, NodesMadeBeforeTheirInterfaceIsUpWaitForIt) {
  const bool permitted = NetworkPair::run([&](NetworkPair& networks) {
    networks.set_link(false);
    const auto begin = std::chrono::steady_clock::now();
    std::thread later([] {
      std::this_thread::sleep_for(1s);
      NetworkPair::set_link(true);
    });
    const auto other = networks.on_far_side([&] { return peer("beat"); });  // without carrier
    EXPECT_GE(std::chrono::steady_clock::now() - begin, 900ms);
    later.join();
    networks.set_link(false);
    later = std::thread([] {
      std::this_thread::sleep_for(500ms);
      NetworkPair::set_link(true);
    });
    const auto self = node();  // down
    later.join();
    Listener listener(*self);
    EXPECT_TRUE(eventually([&] { return listener.beats > 20; })) << listener.beats;
    EXPECT_TRUE(listener.answered());
  });
  if (!permitted) GTEST_SKIP() << "needs root, to make network namespaces";
}

INSTANTIATE_TEST_SUITE_P(, NetworkCut, testing::each_vendor_pair(), testing::pair_name);

}  // namespace
}  // namespace periplus::dds
