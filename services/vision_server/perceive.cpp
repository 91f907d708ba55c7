#include "services/vision_server/perceive.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "services/vision_server/beside.h"
#include "services/vision_server/box_silhouette.h"
#include "services/vision_server/disparity_filter.h"
#include "services/vision_server/match_range.h"

namespace periplus::vision {

namespace {

// Standard deviation of the grey values.
double contrast(const ImageU8& grey) {
  double sum = 0, squares = 0;
  for (std::uint8_t v : grey.data) {
    sum += v;
    squares += static_cast<double>(v) * v;
  }
  const double n = static_cast<double>(grey.data.size());
  return std::sqrt(std::max(0.0, squares / n - sum / n * sum / n));
}

void refuse_blank(const ImageU8& grey, const char* eye, double least) {
  const double c = contrast(grey);
  if (c >= least) return;
  char text[200];
  std::snprintf(text, sizeof text,
                "the %s eye sees nothing: its image has a contrast of %.1f grey levels, at least %.1f are needed; check "
                "lens cap, cable and exposure",
                eye, c, least);
  throw_error(ErrorCode::vision_no_depth, text);
}

double share_of_all(const ImageF& disparity) {
  std::size_t valid = 0;
  for (float d : disparity.data) valid += d > 0;
  return disparity.data.empty() ? 0 : static_cast<double>(valid) / static_cast<double>(disparity.data.size());
}

}  // namespace

void PerceiveSettings::check() const {
  match.check();
  depth.check();
  texture.check();
  features.check();
  require(least_depth_m > 0 && default_far_m > least_depth_m, ErrorCode::bad_input,
          "range: default_far_m must exceed least_depth_m, and that 0");
  require(least_contrast >= 0 && least_valid_share >= 0 && least_valid_share < 1, ErrorCode::bad_input,
          "checks: least_contrast must not be negative, least_valid_share must lie in [0, 1)");
  require(position_sigma_m >= 0 && position_sigma_m <= 10 && rotation_sigma_rad >= 0 && rotation_sigma_rad <= 10, ErrorCode::bad_input,
          "pose: standard deviations must lie in 0..10");
}

object_model::Perception perceive(const RectifiedPair& pair, const object_model::ObjectBox& box,
                                  const Surroundings& surroundings, const PerceiveSettings& settings,
                                  const std::function<double()>& now, PerceiveReport& report) {
  settings.check();
  double last = now();
  const auto step = [&](const char* name) {
    const double t = now();
    report.seconds.emplace_back(name, t - last);
    last = t;
  };
  refuse_blank(pair.left_grey, "left", settings.least_contrast);
  refuse_blank(pair.right_grey, "right", settings.least_contrast);

  const double box_distance = (pair.X_WC.inverse() * box.X_WB.translation()).z();
  require(box_distance > settings.least_depth_m, ErrorCode::bad_input,
          "the object's box is not in front of the camera; check box and camera pose");
  const DepthRange depths = depth_range(pair.rig, pair.X_WC, box, surroundings.scene, settings.least_depth_m,
                                        settings.default_far_m);
  const DisparityPair disparity =
      match(pair.left_grey, pair.right_grey, disparity_range(pair.rig, depths), settings.match);
  step("match");

  object_model::Perception out;
  out.rig = pair.rig;
  out.X_WC = pair.X_WC;
  out.covariance.diagonal().head<3>().setConstant(settings.position_sigma_m * settings.position_sigma_m);
  out.covariance.diagonal().tail<3>().setConstant(settings.rotation_sigma_rad * settings.rotation_sigma_rad);
  report.valid_share = share_of_all(disparity.left);
  report.valid_share_in_box = valid_share(disparity.left, box_silhouette(pair.rig.camera, pair.X_WC, box),
                                          pair.rig.disparity(box_distance));
  if (report.valid_share_in_box < settings.least_valid_share) {
    char text[240];
    std::snprintf(text, sizeof text,
                  "only %.1f %% of the pixels that show the object's box could be matched, at least %.1f %% are needed; "
                  "check that both eyes see it, and that it is lit and textured",
                  100 * report.valid_share_in_box, 100 * settings.least_valid_share);
    throw_error(ErrorCode::vision_no_depth, text);
  }

  // The right eye's part meanwhile.
  struct RightEye {
    object_model::DepthMap depth;
    DetectedFeatures features;
  };
  auto right_eye = beside([&]() -> RightEye {
    const Pose X_WR = pair.X_WC * Eigen::Translation3d(pair.rig.baseline, 0, 0);
    object_model::DepthMap depth = make_depth(disparity.right, pair.rig, X_WR, settings.depth, box_distance);
    DetectedFeatures features = find_right_features(pair.right_grey, pair.rig, pair.X_WC, &depth, box, surroundings.solids, settings.features);
    return {std::move(depth), std::move(features)};
  });
  out.depth.push_back(make_depth(disparity.left, pair.rig, pair.X_WC, settings.depth, box_distance));
  step("depth");
  FilledDisparity filled = fill_disparity(disparity.left, pair.left_grey);
  out.silhouette_valid_share = report.valid_share_in_box;
  report.noise = noise_of(pair.left_grey);
  if (const auto shares = object_shares(disparity.left, filled.disparity, textured_pixels(pair.left_grey, report.noise, settings.texture), pair.rig,
                                        pair.X_WC, box, surroundings.solids)) {
    report.textured_share = shares->textured;
    out.silhouette_valid_share = std::min(out.silhouette_valid_share, shares->valid);
    if (shares->textured < settings.texture.least_share) out.silhouette_valid_share = std::min(out.silhouette_valid_share, shares->textured);
  }
  step("filter");
  RightEye right;
  const auto of_right = [&] {
    right = right_eye.get();
    return std::move(right.features);
  };
  out.features = find_features(pair.left_grey, of_right, pair.rig, out.depth[0], filled, box, surroundings.solids, settings.features);
  out.depth.push_back(std::move(right.depth));
  step("features");
  out.disparity = std::move(filled.disparity);
  out.disparity_filled = std::move(filled.filled);
  out.color = pair.left;
  return out;
}

}  // namespace periplus::vision
