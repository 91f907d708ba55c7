#include "services/vision_server/settings.h"

#include <gtest/gtest.h>

#include <string>

#include "common/core/error.h"

namespace periplus::vision {
namespace {

TEST(VisionSettings, TheDefaultFileSaysWhatTheProgramAssumes) {
  const VisionSettings file = read_settings(config::load_file(std::string(PERIPLUS_SOURCE_DIR) +
                                                              "/services/vision_server/config/default.yaml"));
  const VisionSettings code;
  EXPECT_EQ(file.attempts, code.attempts);
  EXPECT_EQ(file.trigger_deadline, code.trigger_deadline);
  EXPECT_EQ(file.images_deadline, code.images_deadline);
  EXPECT_EQ(file.stamp_tolerance_ns, code.stamp_tolerance_ns);
  EXPECT_EQ(file.views_kept, code.views_kept);
  EXPECT_EQ(file.perceive.match.uniqueness_percent, code.perceive.match.uniqueness_percent);
  EXPECT_EQ(file.perceive.match.left_right_px, code.perceive.match.left_right_px);
  EXPECT_EQ(file.perceive.match.speckle_window, code.perceive.match.speckle_window);
  EXPECT_EQ(file.perceive.depth.footprint_m, code.perceive.depth.footprint_m);
  EXPECT_EQ(file.perceive.texture.window_px, code.perceive.texture.window_px);
  EXPECT_EQ(file.perceive.texture.above_noise, code.perceive.texture.above_noise);
  EXPECT_EQ(file.perceive.texture.least_share, code.perceive.texture.least_share);
  const FeatureSettings &a = file.perceive.features, &b = code.perceive.features;
  EXPECT_EQ(a.most, b.most);
  EXPECT_EQ(a.on_filled, b.on_filled);
  EXPECT_EQ(a.detector.kind, b.detector.kind);
  for (const auto value : {&DetectorSettings::contrast, &DetectorSettings::edge, &DetectorSettings::akaze_response, &DetectorSettings::orb_fast, &DetectorSettings::surf_hessian})
    EXPECT_EQ(a.detector.*value, b.detector.*value);
  EXPECT_EQ(a.selection.method, b.selection.method);
  for (const auto value : {&SelectionSettings::size_min_px, &SelectionSettings::size_max_px, &SelectionSettings::response_min, &SelectionSettings::stereo_px,
                           &SelectionSettings::scale_ratio, &SelectionSettings::most_distance, &SelectionSettings::most_bits, &SelectionSettings::second_ratio})
    EXPECT_EQ(a.selection.*value, b.selection.*value);
  EXPECT_EQ(file.perceive.least_valid_share, code.perceive.least_valid_share);
}

TEST(VisionSettings, ValuesAreTakenAndWrongOnesRefused) {
  EXPECT_EQ(read_settings(config::parse("capture: {stamp_tolerance_s: 0.005}", "t")).stamp_tolerance_ns, 5000000);
  EXPECT_EQ(read_settings(config::parse("matching: {uniqueness_percent: 10}", "t")).perceive.match.uniqueness_percent, 10);
  EXPECT_THROW(read_settings(config::parse("matching: {block_px: 4}", "t")), Error);
  EXPECT_THROW(read_settings(config::parse("capture: {atempts: 3}", "t")), Error);
  EXPECT_THROW(read_settings(config::parse("threads: 0", "t")), Error);
  EXPECT_THROW(read_settings(config::parse("matching: {penalty_2: 1000000}", "t")), Error);
  EXPECT_THROW(read_settings(config::parse("pose: {position_sigma_m: 1e300}", "t")), Error);
  const auto features = read_settings(config::parse("features: {detector: orb, selection: geometry_first, second_ratio: 0.8}", "t")).perceive.features;
  EXPECT_EQ(features.detector.kind, DescriptorKind::orb);
  EXPECT_EQ(features.selection.method, FeatureSelection::geometry_first);
  EXPECT_EQ(features.selection.second_ratio, 0.8);
  EXPECT_THROW(read_settings(config::parse("features: {detector: mser}", "t")), Error);
  if (!unavailable(DescriptorKind::surf).empty()) {
    EXPECT_THROW(read_settings(config::parse("features: {detector: surf}", "t")), Error);
  }
  EXPECT_THROW(read_settings(config::parse("checks: {least_valid_share: 2}", "t")), Error);
}

}  // namespace
}  // namespace periplus::vision
