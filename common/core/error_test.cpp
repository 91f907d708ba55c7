#include "common/core/error.h"

#include <gtest/gtest.h>

namespace periplus {
namespace {

TEST(Error, CarriesCodeAndSentence) {
  try {
    require(false, ErrorCode::walk_no_path, "no path");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::walk_no_path);
    EXPECT_STREQ(e.what(), "no path");
  }
}

TEST(Error, EveryNameIsKnown) {
  EXPECT_STREQ(to_string(ErrorCode::posture_infeasible), "posture_infeasible");
  EXPECT_STREQ(to_string(static_cast<ErrorCode>(9999)), "unknown");
}

}  // namespace
}  // namespace periplus
