#include "common/dds/network_interface.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "common/core/error.h"
#include "common/dds/testing/network_namespace.h"

namespace periplus::dds {
namespace {

TEST(NetworkInterface, LoopbackIsFoundByNameAndByAddress) {
  EXPECT_EQ(find_interface("lo").address, "127.0.0.1");
  EXPECT_TRUE(find_interface("127.0.0.1").loopback);
  EXPECT_TRUE(interface_is_up("lo"));
}

TEST(NetworkInterface, OneThatIsDownIsWaitedForAndOneThatIsNotThereIsNot) {
  const bool permitted = testing::NetworkPair::run([&](testing::NetworkPair& networks) {
    using std::chrono::milliseconds;
    EXPECT_EQ(wait_for_interface(networks.near_interface, milliseconds(5000)).address, networks.near_address);  // carrier takes a moment
    EXPECT_TRUE(interface_is_up("any"));
    networks.set_link(false);
    EXPECT_FALSE(interface_is_up(networks.near_interface));
    EXPECT_FALSE(interface_is_up("any"));
    EXPECT_THROW(find_interface(networks.near_interface), Error);
    EXPECT_THROW(wait_for_interface(networks.near_interface, milliseconds(50)), Error);
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_THROW(wait_for_interface("nowhere0", milliseconds(5000)), Error);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, milliseconds(2000));
    // Up, but with nothing at the other end of the cable.
    EXPECT_FALSE(networks.on_far_side([&] { return interface_is_up(networks.far_interface); }));
    std::thread later([] {
      std::this_thread::sleep_for(milliseconds(200));
      testing::NetworkPair::set_link(true);
    });
    EXPECT_EQ(wait_for_interface(networks.near_interface, milliseconds(5000)).address, networks.near_address);
    later.join();
  });
  if (!permitted) GTEST_SKIP() << "needs root, to make network namespaces";
}

TEST(NetworkInterface, AnyBindsToNone) { EXPECT_TRUE(find_interface("any").address.empty()); }

TEST(NetworkInterface, UnknownOneIsRefusedNamingThoseThatExist) {
  EXPECT_FALSE(interface_is_up("nowhere0"));
  try {
    find_interface("nowhere0");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_NE(std::string(error.what()).find("lo (127.0.0.1)"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace periplus::dds
