#include "integration-tests/nbv_benchmark/compare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/core/error.h"

namespace periplus::nbv_benchmark {
namespace {

using nlohmann::json;

json run(const std::string& planner, const std::vector<double>& visible, double error) {
  return {{"planner", planner}, {"coverage", {{"visible", visible}}}, {"surface_error_m", {{"mean", error}}}, {"seconds", {{"plan", {0, 0.1, 0.3}}}}};
}

// One object of which the oracle sees 96 % with the second view.
json report(std::uint64_t seed, const std::vector<double>& ours, const std::vector<double>& other) {
  json objects = {{{"name", "mug"}, {"runs", {run("ours", ours, 0.001), run("ours:ahead", other, 0.003), run("oracle", {0.5, 0.96, 1}, 0)}}}};
  json summary = {{{"planner", "ours"}}, {{"planner", "ours:ahead"}}, {{"planner", "oracle"}}};
  return {{"parameters", {{"seed", seed}}},
          {"made", {{"commit", "0123abc"}, {"machine", "one machine"}}},
          {"settings", {{{"name", "free/ideal/single"}, {"objects", objects}, {"summary", summary}}}}};
}

TEST(Compare, MeansDifferencesAndLagsBySeed) {
  const std::vector<json> reports = {report(1, {0.5, 0.9, 0.94}, {0.5, 0.96, 0.99}), report(2, {0.5, 0.8, 0.96}, {0.5, 0.8, 0.96})};
  const std::vector<Compared> rows = compare(reports);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[1].planner, "ours:ahead");
  EXPECT_EQ(rows[0].runs, 2);
  EXPECT_NEAR(rows[0].auc, (0.81 + 0.765) / 2, 1e-12);
  EXPECT_EQ(rows[0].ahead, 0);
  // 0.0425 with the first seed, nothing with the second: the mean's standard error is half their difference.
  EXPECT_NEAR(rows[1].ahead, 0.0425 / 2, 1e-12);
  EXPECT_NEAR(rows[1].ahead_error, 0.0425 / 2, 1e-12);
  EXPECT_NEAR(rows[0].views[0], 2.5, 1e-12);
  EXPECT_NEAR(rows[0].views[1], 3.5, 1e-12) << "not reached in three views counts as four";
  EXPECT_EQ(rows[0].behind_oracle[0], 0);
  EXPECT_EQ(rows[0].behind_oracle[1], 1) << "four views against two; three against two are allowed";
  EXPECT_EQ(rows[1].behind_oracle[1], 0);
  EXPECT_NEAR(rows[1].error, 0.003, 1e-12);
  EXPECT_NEAR(rows[0].plan_seconds, 0.2, 1e-12) << "the first view is not planned";
  const std::string text = to_markdown(rows, reports);
  EXPECT_NE(text.find("| `ours:ahead` | 0.8088 | +213 ± 213 |"), std::string::npos) << text;
  EXPECT_NE(text.find("Seeds 1, 2; commit and machine: 0123abc, one machine."), std::string::npos) << text;
}

TEST(Compare, ReportsThatDoNotFitAreRefused) {
  const json one = report(1, {0.5, 0.9, 0.94}, {0.5, 0.96, 0.99});
  EXPECT_THROW(compare({}), Error);
  EXPECT_THROW(compare({one, one}), Error) << "the same seed twice";
  json fewer = report(2, {0.5, 0.9, 0.94}, {0.5, 0.96, 0.99});
  fewer["settings"][0]["objects"][0]["runs"].erase(1);
  EXPECT_THROW(compare({one, fewer}), Error);
}

}  // namespace
}  // namespace periplus::nbv_benchmark
