#include "services/vision_server/settings.h"

#include <cmath>

namespace periplus::vision {

namespace {

void read_seconds(const config::Node& node, const char* key, std::chrono::milliseconds& value) {
  double seconds = static_cast<double>(value.count()) / 1000;
  node.read(key, seconds, {.minimum = 0.001, .maximum = 600});
  value = std::chrono::milliseconds(std::lround(seconds * 1000));
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

  const config::Node features = root.child("features");
  features.read("contrast", p.features.contrast);
  features.read("edge", p.features.edge);
  features.read("most", p.features.most);
  features.read("cell_px", p.features.cell_px);
  features.read("size_min_px", p.features.size_min_px);
  features.read("size_max_px", p.features.size_max_px);
  features.read("grow_box_m", p.features.grow_box_m);
  features.read("stereo_px", p.features.stereo_px);
  features.read("scale_ratio", p.features.scale_ratio);

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
