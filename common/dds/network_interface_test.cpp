#include "common/dds/network_interface.h"

#include <gtest/gtest.h>

#include "common/core/error.h"

namespace periplus::dds {
namespace {

TEST(NetworkInterface, LoopbackIsFoundByNameAndByAddress) {
  EXPECT_EQ(find_interface("lo").address, "127.0.0.1");
  EXPECT_TRUE(find_interface("127.0.0.1").loopback);
  EXPECT_TRUE(interface_is_up("lo"));
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
