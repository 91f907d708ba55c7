#include "common/core/utf8.h"

#include <gtest/gtest.h>

#include <string>

namespace periplus {
namespace {

TEST(Utf8, LengthsOfSequences) {
  EXPECT_EQ(utf8_length("a"), 1u);
  EXPECT_EQ(utf8_length("\u00e9x"), 2u);
  EXPECT_EQ(utf8_length("\u65e5"), 3u);
  EXPECT_EQ(utf8_length("\U0001F600"), 4u);
  for (const char* bad : {"\x80", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80", "\xf0\x80\x80\x80", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xe6\x97", "\xff"})
    EXPECT_EQ(utf8_length(bad), 0u);
}

TEST(Utf8, FindsWhereATextIsNot) {
  EXPECT_EQ(first_not_utf8(""), std::string_view::npos);
  EXPECT_EQ(first_not_utf8("caf\u00e9"), std::string_view::npos);
  EXPECT_EQ(first_not_utf8("caf\xe9 noir"), 3u);
  EXPECT_EQ(first_not_utf8("\u65e5\xe6\x97"), 3u);
}

}  // namespace
}  // namespace periplus
