#include "services/model_server/settings.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "common/core/error.h"

namespace periplus::model {
namespace {

TEST(Settings, DefaultFileHoldsTheDefaults) {
  const ModelSettings file = read_settings(config::load_file(PERIPLUS_SOURCE_DIR "/services/model_server/config/default.yaml"));
  const ModelSettings code;
  EXPECT_EQ(file.perception_wait, code.perception_wait);
  EXPECT_EQ(file.perceptions_kept, code.perceptions_kept);
  EXPECT_EQ(file.ros_topics, code.ros_topics);
  EXPECT_EQ(file.carving.margin_voxels, code.carving.margin_voxels);
  EXPECT_EQ(file.carving.gap_px, code.carving.gap_px);
  EXPECT_EQ(file.carving.cautious_share, code.carving.cautious_share);
  EXPECT_EQ(file.carving.cautious_votes, code.carving.cautious_votes);
  EXPECT_EQ(file.carving.solid_extra_voxels, code.carving.solid_extra_voxels);
  EXPECT_EQ(file.carving.solid_tolerance_m, code.carving.solid_tolerance_m);
  EXPECT_EQ(file.carving.known_points, code.carving.known_points);
  const object_model::LandmarkSettings &a = file.landmarks, &b = code.landmarks;
  EXPECT_EQ(a.reach_m, b.reach_m);
  EXPECT_EQ(a.most_turn, b.most_turn);
  using Matching = object_model::MatchingSettings;
  for (const auto value : {&Matching::most_distance, &Matching::most_bits, &Matching::ratio, &Matching::distance_m, &Matching::distance_share, &Matching::coherent_share})
    EXPECT_EQ(a.matching.*value, b.matching.*value);
  for (const auto value : {&Matching::least_coherent, &Matching::most}) EXPECT_EQ(a.matching.*value, b.matching.*value);
  EXPECT_EQ(file.carving.seen_points, code.carving.seen_points);
  EXPECT_EQ(file.carving.truncation_voxels, code.carving.truncation_voxels);
  EXPECT_TRUE(file.carving == code.carving);
  EXPECT_TRUE(file.growth == code.growth);
}

TEST(Settings, RefusesUnknownKeysAndValuesOutOfRange) {
  EXPECT_THROW(read_settings(config::parse("carving: {margin_voxel: 1}", "test")), Error);
  EXPECT_THROW(read_settings(config::parse("carving: {margin_voxels: 0.1}", "test")), Error);
  EXPECT_THROW(read_settings(config::parse("perception_wait_s: -1", "test")), Error);
  EXPECT_THROW(read_settings(config::parse("landmarks: {ratio: 1.5}", "test")), Error);
  EXPECT_DOUBLE_EQ(read_settings(config::parse("landmarks: {reach_m: 0.03}", "test")).landmarks.reach_m, 0.03);
  EXPECT_THROW(read_settings(config::parse("carving: {mode: bold}", "test")), Error);
  EXPECT_THROW(read_settings(config::parse("log_odds: {miss: 0.4}", "test")), Error);
  EXPECT_THROW(read_settings(config::parse("growth: {least_voxels: 0}", "test")), Error);
  EXPECT_FALSE(read_settings(config::parse("growth: {enabled: false}", "test")).growth.enabled);
  EXPECT_EQ(read_settings(config::parse("carving: {mode: probabilistic}", "test")).carving.mode, object_model::CarvingMode::probabilistic);
  EXPECT_DOUBLE_EQ(read_settings(config::parse("carving: {margin_voxels: 1.5}", "test")).carving.margin_voxels, 1.5);
}

TEST(Settings, StoreFolderFollowsTheEnvironment) {
  const char* before = std::getenv("XDG_STATE_HOME");
  const std::string kept = before ? before : "";
  ::setenv("XDG_STATE_HOME", "/var/tmp/state", 1);
  EXPECT_EQ(default_store_folder(7), "/var/tmp/state/periplus/domain-7");
  before ? ::setenv("XDG_STATE_HOME", kept.c_str(), 1) : ::unsetenv("XDG_STATE_HOME");
}

}  // namespace
}  // namespace periplus::model
