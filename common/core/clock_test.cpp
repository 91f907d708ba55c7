#include "common/core/clock.h"

#include <gtest/gtest.h>

#include <limits>

namespace periplus {
namespace {

TEST(Clock, Units) {
  EXPECT_EQ(milliseconds(0.25), std::chrono::milliseconds(250));
  EXPECT_EQ(milliseconds(86400), std::chrono::hours(24));
  EXPECT_NEAR(seconds_since(std::chrono::steady_clock::now() - std::chrono::milliseconds(1500)), 1.5, 0.5);
  EXPECT_GT(wall_time_ns(), 1'700'000'000'000'000'000);   // 2023
  EXPECT_LT(wall_time_ns(), std::numeric_limits<std::int64_t>::max() / 2);
}

}  // namespace
}  // namespace periplus
