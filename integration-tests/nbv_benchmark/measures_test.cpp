#include "integration-tests/nbv_benchmark/measures.h"

#include <gtest/gtest.h>

namespace periplus::nbv_benchmark {
namespace {

TEST(Measures, AreaUnderKnownCurves) {
  EXPECT_DOUBLE_EQ(area_under({}), 0);
  EXPECT_DOUBLE_EQ(area_under({0.4}), 0.4);
  EXPECT_DOUBLE_EQ(area_under({0.7, 0.7, 0.7}), 0.7);
  // A straight line from 0 to 1: one half, whatever its length.
  EXPECT_DOUBLE_EQ(area_under({0, 1}), 0.5);
  EXPECT_NEAR(area_under({0, 0.25, 0.5, 0.75, 1}), 0.5, 1e-15);
  // 0.4 0.8 1: (0.6 + 0.9) / 2.
  EXPECT_NEAR(area_under({0.4, 0.8, 1}), 0.75, 1e-15);
  // Early coverage is worth more than late.
  EXPECT_GT(area_under({0.4, 0.9, 0.9, 1}), area_under({0.4, 0.5, 0.9, 1}));
}

TEST(Measures, ViewsToALevel) {
  const std::vector<double> c = {0.4, 0.9, 0.95, 0.989};
  EXPECT_EQ(views_to(c, 0.4), 1);
  EXPECT_EQ(views_to(c, 0.90), 2);
  EXPECT_EQ(views_to(c, 0.95), 3);
  EXPECT_EQ(views_to(c, 0.99), std::nullopt);
  EXPECT_EQ(views_to({}, 0.5), std::nullopt);
}

TEST(Measures, ALevelThatNobodyReachesIsSaidToBeSo) {
  const std::vector<std::vector<double>> all = {{0.4, 0.8, 0.96}, {0.4, 0.7, 0.93}};
  EXPECT_EQ(views_to_text(all[0], all, 0.95), "3");
  EXPECT_EQ(views_to_text(all[1], all, 0.95), "> 3");
  EXPECT_EQ(views_to_text(all[0], all, 0.99), "not reachable");
  EXPECT_EQ(views_to_text(all[1], all, 0.99), "not reachable");
}

}  // namespace
}  // namespace periplus::nbv_benchmark
