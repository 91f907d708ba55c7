#include "common/object_model/compression.h"

#include <gtest/gtest.h>

#include <numeric>

#include "common/core/error.h"

namespace periplus::object_model {
namespace {

TEST(Compression, GivesBackWhatItTook) {
  std::vector<std::uint32_t> numbers(5000);
  std::iota(numbers.begin(), numbers.end(), 70000u);
  const std::string packed = pack_bytes(numbers.data(), numbers.size(), 4);
  EXPECT_LT(packed.size(), numbers.size() * 2);
  std::vector<std::uint32_t> back(numbers.size());
  unpack_bytes(packed, back.size(), 4, back.data());
  EXPECT_EQ(back, numbers);
}

TEST(Compression, RefusesOtherSizesAndDamage) {
  const std::vector<std::uint16_t> numbers(1000, 7);
  const std::string packed = pack_bytes(numbers.data(), numbers.size(), 2);
  std::vector<std::uint16_t> back(2000);
  EXPECT_THROW(unpack_bytes(packed, 999, 2, back.data()), Error);
  EXPECT_THROW(unpack_bytes(packed, 1001, 2, back.data()), Error);
  EXPECT_THROW(unpack_bytes(packed.substr(0, packed.size() - 3), 1000, 2, back.data()), Error);
  EXPECT_THROW(unpack_bytes("", 1000, 2, back.data()), Error);
}

TEST(Compression, KnowsWhatCannotFit) {
  EXPECT_FALSE(may_hold("abc", 1u << 30));
  const std::vector<std::uint8_t> zeros(1u << 20);
  EXPECT_TRUE(may_hold(pack_bytes(zeros.data(), zeros.size(), 1), zeros.size()));
}

}  // namespace
}  // namespace periplus::object_model
