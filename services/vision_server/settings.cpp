#include "services/vision_server/settings.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace periplus::vision {

namespace {

void read_seconds(const config::Node& node, const char* key, std::chrono::milliseconds& value) {
  double seconds = static_cast<double>(value.count()) / 1000;
  node.read(key, seconds, {.minimum = 0.001, .maximum = 600});
  value = std::chrono::milliseconds(std::lround(seconds * 1000));
}

template <class T>
void choose(const config::Node& node, const char* key, T& value, const std::vector<std::pair<std::string, T>>& choices) {
  std::string name;
  std::vector<std::string> names;
  for (const auto& [known, meaning] : choices) names.push_back(known);
  if (node.read_choice(key, name, names)) value = std::find_if(choices.begin(), choices.end(), [&](const auto& c) { return c.first == name; })->second;
}

void read_features(const config::Node& node, FeatureSettings& f) {
  choose<DescriptorKind>(node, "detector", f.detector.kind,
                         {{"sift", DescriptorKind::root_sift}, {"akaze", DescriptorKind::akaze}, {"orb", DescriptorKind::orb}, {"surf", DescriptorKind::surf}});
  node.read("contrast", f.detector.contrast);
  node.read("edge", f.detector.edge);
  node.read("akaze_response", f.detector.akaze_response);
  node.read("orb_fast", f.detector.orb_fast);
  node.read("surf_hessian", f.detector.surf_hessian);
  choose<FeatureSelection>(node, "selection", f.selection.method,
                           {{"descriptor_first", FeatureSelection::descriptor_first}, {"geometry_first", FeatureSelection::geometry_first}, {"left_alone", FeatureSelection::left_alone}});
  node.read("size_min_px", f.selection.size_min_px);
  node.read("size_max_px", f.selection.size_max_px);
  node.read("response_min", f.selection.response_min);
  node.read("stereo_px", f.selection.stereo_px);
  node.read("scale_ratio", f.selection.scale_ratio);
  node.read("most_distance", f.selection.most_distance);
  node.read("most_bits", f.selection.most_bits);
  node.read("second_ratio", f.selection.second_ratio);
  node.read("most", f.most);
  node.read("cell_px", f.cell_px);
  node.read("grow_box_m", f.grow_box_m);
  node.read("on_filled", f.on_filled);
}

}  // namespace

VisionSettings read_settings(const config::Node& root) {
  VisionSettings s;
  root.read("threads", s.threads, {.minimum = 1, .maximum = 64});

  const config::Node capture = root.child("capture");
  capture.read("attempts", s.attempts, {.minimum = 1, .maximum = 100});
  read_seconds(capture, "trigger_deadline_s", s.trigger_deadline);
  read_seconds(capture, "images_deadline_s", s.images_deadline);
  double tolerance_s = 0;
  capture.read("stamp_tolerance_s", tolerance_s, {.minimum = 0, .maximum = 0.1});
  s.stamp_tolerance_ns = std::llround(tolerance_s * 1e9);
  capture.read("views_kept", s.views_kept, {.minimum = 1, .maximum = 1000});

  PerceiveSettings& p = s.perceive;
  const config::Node range = root.child("range");
  range.read("least_depth_m", p.least_depth_m);
  range.read("default_far_m", p.default_far_m);

  const config::Node matching = root.child("matching");
  matching.read("block_px", p.match.block);
  matching.read("penalty_1", p.match.penalty_1);
  matching.read("penalty_2", p.match.penalty_2);
  matching.read("prefilter_cap", p.match.prefilter_cap);
  matching.read("uniqueness_percent", p.match.uniqueness_percent);
  matching.read("speckle_window_px", p.match.speckle_window);
  matching.read("speckle_range_px", p.match.speckle_range);
  matching.read("left_right_px", p.match.left_right_px);

  const config::Node depth = root.child("depth");
  depth.read("disparity_sigma_px", p.depth.disparity_sigma_px);
  depth.read("footprint_m", p.depth.footprint_m);
  depth.read("flying_window_px", p.depth.flying_window_px);
  depth.read("flying_range_px", p.depth.flying_range_px);

  const config::Node texture = root.child("texture");
  texture.read("window_px", p.texture.window_px);
  texture.read("above_noise", p.texture.above_noise);
  texture.read("least_share", p.texture.least_share);

  const config::Node features = root.child("features");
  read_features(features, p.features);

  const config::Node pose = root.child("pose");
  pose.read("position_sigma_m", p.position_sigma_m);
  pose.read("rotation_sigma_rad", p.rotation_sigma_rad);

  const config::Node checks = root.child("checks");
  checks.read("least_contrast", p.least_contrast);
  checks.read("least_valid_share", p.least_valid_share);

  root.finish();
  p.check();
  return s;
}

}  // namespace periplus::vision
