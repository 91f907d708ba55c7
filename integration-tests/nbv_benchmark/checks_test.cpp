#include "integration-tests/nbv_benchmark/checks.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "integration-tests/nbv_benchmark/measures.h"

namespace periplus::nbv_benchmark {
namespace {

using nlohmann::json;

json run(const std::string& planner, const std::vector<double>& visible, const std::vector<double>& all) {
  return {{"planner", planner}, {"coverage", {{"visible", visible}, {"all", all}}}};
}

// Two objects in one setting; `ours` is given, the oracle needs 3 views to 95 %, a gain of the literature 5.
json report(const std::vector<double>& bunny, const std::vector<double>& mug, double stereo_loss) {
  const std::vector<double> oracle = {0.4, 0.91, 0.96, 0.99, 0.99, 0.995}, gain = {0.4, 0.6, 0.8, 0.9, 0.96, 0.97};
  json objects = {{{"name", "bunny"}, {"runs", {run("ours", bunny, bunny), run("unobserved", gain, gain), run("oracle", oracle, oracle)}}},
                  {{"name", "mug"}, {"runs", {run("ours", mug, mug), run("unobserved", gain, gain), run("oracle", oracle, oracle)}}}};
  const auto summary = [](const std::string& planner, double auc, double last) {
    return json{{"planner", planner}, {"auc_visible_mean", auc}, {"coverage_visible_mean", last}};
  };
  const double last = (bunny.back() + mug.back()) / 2;
  json summaries = {summary("ours", mean({area_under(bunny), area_under(mug)}), last), summary("unobserved", area_under(gain), 0.97), summary("oracle", area_under(oracle), 0.995)};
  json j;
  j["settings"] = {{{"name", "free/ideal/single"}, {"poses", "free"}, {"sensor", "ideal"}, {"camera", "single"}, {"objects", objects}, {"summary", summaries}},
                   {{"name", "reachable/ideal/pair"}, {"poses", "reachable"}, {"sensor", "ideal"}, {"camera", "pair"}, {"objects", objects}, {"summary", summaries}},
                   {{"name", "reachable/stereo/pair"}, {"poses", "reachable"}, {"sensor", "stereo"}, {"camera", "pair"}, {"objects", objects}, {"summary", {summary("ours", 0.9, last - stereo_loss)}}}};
  return j;
}

std::map<std::string, Check> by_name(const json& r) {
  std::map<std::string, Check> out;
  for (const Check& c : check_criteria(r)) out[c.name] = c;
  return out;
}

TEST(Checks, GoodRunsPass) {
  const std::vector<double> good = {0.4, 0.88, 0.94, 0.97, 0.99, 0.992};
  const auto checks = by_name(report(good, good, 0.02));
  EXPECT_EQ(checks.size(), 12u);
  for (const auto& [name, c] : checks) EXPECT_TRUE(c.ok && c.known) << name << " " << c.value;
}

TEST(Checks, EachCriterionFindsItsFault) {
  const std::vector<double> good = {0.4, 0.88, 0.94, 0.97, 0.99, 0.992}, late = {0.4, 0.6, 0.8, 0.9, 0.945, 0.992}, poor = {0.4, 0.5, 0.6, 0.7, 0.8, 0.93};
  EXPECT_FALSE(by_name(report({0.4, 0.88, 0.94, 0.96, 0.98, 0.989}, good, 0)).at("free.bunny_all_6").ok);
  EXPECT_FALSE(by_name(report(good, poor, 0)).at("free.mean_of_visible_10").ok);
  EXPECT_FALSE(by_name(report(good, poor, 0)).at("free.worst_of_visible_10").ok);
  EXPECT_EQ(by_name(report(good, poor, 0)).at("free.worst_of_visible_10").detail, "mug");
  // 90 % at view 4 against 2, 95 % at view 6 against 3.
  EXPECT_EQ(by_name(report(good, late, 0)).at("free.behind_oracle_90").value, 2);
  EXPECT_EQ(by_name(report(good, late, 0)).at("free.behind_oracle_95").value, 3);
  EXPECT_FALSE(by_name(report(good, late, 0)).at("free.behind_oracle_95").ok);
  EXPECT_FALSE(by_name(report(poor, poor, 0)).at("free.ahead_of_literature").ok);
  EXPECT_FALSE(by_name(report(good, good, 0.031)).at("reachable.stereo_behind_ideal").ok);
}

TEST(Checks, WhatIsNotThereDoesNotPass) {
  const std::vector<Check> checks = check_criteria({{"settings", json::array()}});
  ASSERT_GE(checks.size(), 2u);
  for (const Check& c : checks) EXPECT_FALSE(c.ok || c.known) << c.name;
}

}  // namespace
}  // namespace periplus::nbv_benchmark
