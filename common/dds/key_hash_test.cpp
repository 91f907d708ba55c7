#include "common/dds/key_hash.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/core/hash.h"
#include "common/dds/codec_impl.h"
#include "idl/common.h"

namespace periplus::dds {
namespace {

TEST(KeyHash, IsTheMd5OfTheBigEndianKeyWhereKeysMayBeLong) {
  msg::ServiceStatus status;
  status.instance("ab");
  const std::array<std::uint8_t, 7> key = {0, 0, 0, 3, 'a', 'b', 0};
  EXPECT_EQ(key_hash(codec<msg::ServiceStatus>(), &status, false), md5(key.data(), key.size()));
}

TEST(KeyHash, IsTheKeyItselfWhereItIsShort) {
  Codec short_key = codec<msg::ServiceStatus>();
  short_key.key_md5 = false;
  msg::ServiceStatus status;
  status.instance("ab");
  const KeyHash expected = {0, 0, 0, 3, 'a', 'b', 0};
  EXPECT_EQ(key_hash(short_key, &status, false), expected);
  EXPECT_NE(key_hash(short_key, &status, true), expected);
}

TEST(KeyHash, IsZeroWithoutAKey) {
  const msg::Cancel sample;
  EXPECT_EQ(key_hash(codec<msg::Cancel>(), &sample, true), KeyHash{});
}

}  // namespace
}  // namespace periplus::dds
