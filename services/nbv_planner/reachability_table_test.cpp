#include "services/nbv_planner/reachability_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::nbv {
namespace {

Pose eye(double height, double pitch, double yaw = 0.7) { return look_along({1.2, -0.4, height}, yaw, pitch); }

TEST(ReachabilityTable, GivesItsNumbersAndIsLinearBetweenThem) {
  const ReachabilityTable table({1.0, 1.2, 1.3}, {-0.4, 0.6}, {0.2, 0.4, 1.0, 0.8, 0.0, 0.6});
  EXPECT_NEAR(table.of(eye(1.0, -0.4)), 0.2, 1e-12);
  EXPECT_NEAR(table.of(eye(1.2, -0.4)), 1.0, 1e-12);
  EXPECT_NEAR(table.of(eye(1.3, 0.6)), 0.6, 1e-12);
  EXPECT_NEAR(table.of(eye(1.1, -0.4)), 0.6, 1e-12);
  EXPECT_NEAR(table.of(eye(1.2, 0.1)), 0.9, 1e-12);
  EXPECT_NEAR(table.of(eye(1.25, 0.1)), (1.0 + 0.8 + 0.0 + 0.6) / 4, 1e-12);
  // Beyond them as at the nearest; where it stands and where it turns to do not matter.
  EXPECT_NEAR(table.of(eye(0.3, -1.2)), 0.2, 1e-12);
  EXPECT_NEAR(table.of(eye(2.0, 0.1)), 0.3, 1e-12);
  EXPECT_EQ(table.of(eye(1.15, 0.3, 2.5)), table.of(eye(1.15, 0.3, 2.5)));
  EXPECT_NEAR(table.of(eye(1.15, 0.3, 2.5)), table.of(eye(1.15, 0.3, -1)), 1e-12);
}

// A plane over height and pitch is given back exactly by any table of it, within its bounds.
TEST(ReachabilityTable, APlaneIsGivenBack) {
  const auto plane = [](double height, double pitch) { return 0.1 + 0.4 * (height - 0.9) + 0.2 * (pitch + 0.5); };
  Random random(5);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> heights{0.9}, pitches{-0.5}, shares;
    for (int i = 0; i < trial % 5; ++i) heights.push_back(heights.back() + random.uniform(0.01, 0.2));
    for (int j = 0; j < trial % 4; ++j) pitches.push_back(pitches.back() + random.uniform(0.01, 0.4));
    for (const double h : heights)
      for (const double p : pitches) shares.push_back(plane(h, p));
    const ReachabilityTable table(heights, pitches, shares);
    for (int n = 0; n < 50; ++n) {
      const double h = random.uniform(heights.front(), heights.back()), p = random.uniform(pitches.front(), pitches.back());
      EXPECT_NEAR(table.of(eye(h, p)), plane(h, p), 1e-9);
    }
  }
}

TEST(ReachabilityTable, OneNumberIsAConstant) {
  const ReachabilityTable table({1.2}, {0}, {0.7});
  EXPECT_EQ(table.of(eye(0.5, -1)), 0.7);
  EXPECT_EQ(table.of(eye(2.5, 1)), 0.7);
}

TEST(ReachabilityTable, BadOnesAreRefused) {
  EXPECT_THROW(ReachabilityTable({}, {0}, {}), Error);
  EXPECT_THROW(ReachabilityTable({1}, {}, {}), Error);
  EXPECT_THROW(ReachabilityTable({1, 1}, {0}, {0, 0}), Error);
  EXPECT_THROW(ReachabilityTable({1.2, 1.1}, {0}, {0, 0}), Error);
  EXPECT_THROW(ReachabilityTable({1, 2}, {0}, {0.5}), Error);
  EXPECT_THROW(ReachabilityTable({1}, {0}, {1.1}), Error);
  EXPECT_THROW(ReachabilityTable({1}, {0}, {std::nan("")}), Error);
  EXPECT_THROW(ReachabilityTable({HUGE_VAL}, {0}, {1}), Error);
}

}  // namespace
}  // namespace periplus::nbv
