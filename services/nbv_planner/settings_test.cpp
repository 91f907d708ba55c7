#include "services/nbv_planner/settings.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "common/core/error.h"

namespace periplus::nbv {
namespace {

TEST(Settings, ShippedConfigurationIsTheDefault) {
  const Settings s = read_settings(config::load_file(PERIPLUS_SOURCE_DIR "/services/nbv_planner/config/default.yaml"));
  const Settings d;
  EXPECT_EQ(s.search.method, d.search.method);
  EXPECT_EQ(s.search.fast, d.search.fast);
  EXPECT_EQ(s.search.thorough, d.search.thorough);
  EXPECT_EQ(s.search.thesis, d.search.thesis);
  EXPECT_EQ(s.search.lookahead, d.search.lookahead);
  EXPECT_EQ(s.search.max_evaluations, d.search.max_evaluations);
  EXPECT_EQ(s.search.threads, d.search.threads);
  EXPECT_EQ(s.evaluation.quantification, Quantification::mixed);
  EXPECT_EQ(s.evaluation.pixels_per_voxel_share, d.evaluation.pixels_per_voxel_share);
  EXPECT_EQ(s.evaluation.lambda_rule, LambdaRule::capped);
  EXPECT_EQ(s.evaluation.likely_within, d.evaluation.likely_within);
  EXPECT_EQ(s.evaluation.quality_weight, d.evaluation.quality_weight);
  EXPECT_EQ(s.evaluation.quality_reference, d.evaluation.quality_reference);
  EXPECT_EQ(s.evaluation.lambda_motion, 0);
  EXPECT_EQ(s.evaluation.lambda_reach, 0);
  EXPECT_EQ(s.reachability, nullptr);
  EXPECT_EQ(s.evaluation.interval_exponent, 6);
  EXPECT_EQ(s.evaluation.distance_slope, 20);
  EXPECT_EQ(s.evaluation.least_landmarks, 5);
  EXPECT_EQ(s.evaluation.lambda_distance, 100);
  EXPECT_EQ(s.evaluation.lambda_landmarks, 1);
  EXPECT_EQ(s.evaluation.lambda_forbidden, 1000);
  EXPECT_EQ(s.evaluation.pair.more_than_pixels, 5);
  EXPECT_NEAR(s.constraints.forbidden_angle, d.constraints.forbidden_angle, 1e-12);
  EXPECT_EQ(s.constraints.head_radius, d.constraints.head_radius);
}

TEST(Settings, BadOnesAreRefused) {
  const auto read = [](const char* yaml) { return read_settings(config::parse(yaml, "test.yaml")); };
  EXPECT_EQ(read("search: {thorough: {starts: 3}}").search.thorough.starts, 3);
  EXPECT_EQ(read("search: {method: thesis, thesis: {local: newuoa}}").search.thesis.local, ThesisLocal::newuoa);
  EXPECT_THROW(read("search: {starts: 3}"), Error);
  EXPECT_THROW(read("search: {fast: {starts: 0}}"), Error);
  EXPECT_THROW(read("search: {method: slow}"), Error);
  EXPECT_THROW(read("evaluation: {interval_exponent: 5}"), Error);
  EXPECT_EQ(read("evaluation: {quantification: pixels}").evaluation.quantification, Quantification::pixels);
  EXPECT_EQ(read("evaluation: {lambda_rule: fixed}").evaluation.lambda_rule, LambdaRule::fixed);
  EXPECT_THROW(read("evaluation: {quantification: pixel}"), Error);
  EXPECT_THROW(read("evaluation: {pair_depth_min_m: 3}"), Error);
}

TEST(Settings, ReachabilityIsATableOfConstants) {
  const auto read = [](const char* yaml) { return read_settings(config::parse(yaml, "test.yaml")).reachability; };
  const auto table = read("reachability: {heights_m: [1.0, 1.2], pitches_deg: [0, 60], shares: [0, 0.4, 1, 0.8]}");
  ASSERT_NE(table, nullptr);
  EXPECT_NEAR(table->of(look_along({0, 0, 1.1}, 2, std::numbers::pi / 6)), (0 + 0.4 + 1 + 0.8) / 4, 1e-12);
  EXPECT_EQ(read("evaluation: {lambda_reach: 1}"), nullptr);
  try {
    read("reachability: {heights_m: [1.0, 1.2], pitches_deg: [0], shares: [0.5]}");
    ADD_FAILURE() << "too few shares";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    EXPECT_NE(std::string(e.what()).find("needs 2 shares, got 1"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("test.yaml:1"), std::string::npos) << e.what();
  }
  EXPECT_THROW(read("reachability: {shares: [0.5]}"), Error);
  EXPECT_THROW(read("reachability: {heights_m: [1], pitches_deg: [0], shares: [2]}"), Error);
}

TEST(Settings, PlannersAreAlikeIfTheirViewsAre) {
  const auto alike = [](const char* yaml) {
    config::Node root = config::load_file(PERIPLUS_SOURCE_DIR "/services/nbv_planner/config/default.yaml");
    config::overlay(root, config::parse(yaml, "test.yaml"));
    return read_settings(root).alike;
  };
  const std::string some = alike("search: {max_evaluations: 900, threads: 2}");
  EXPECT_EQ(some.size(), 64u);
  EXPECT_EQ(some, alike("other_instances: 3\nrevision_wait_s: 1\nsearch: {threads: 1, max_evaluations: 900}"));
  EXPECT_NE(some, alike("search: {max_evaluations: 901, threads: 2}"));
  EXPECT_NE(some, alike("search: {max_evaluations: 900}\nreachability: {heights_m: [1], pitches_deg: [0], shares: [0.5]}"));
  EXPECT_NE(some, alike("search: {max_evaluations: 900}\nevaluation: {least_landmarks: 6}"));
}

}  // namespace
}  // namespace periplus::nbv
