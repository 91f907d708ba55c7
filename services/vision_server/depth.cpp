#include "services/vision_server/depth.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace periplus::vision {

namespace {

cv::Mat box_filter(const cv::Mat& image, int side, bool maximum) {
  cv::Mat out;
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {side, side});
  if (maximum)
    cv::dilate(image, out, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
  else
    cv::erode(image, out, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
  return out;
}

}  // namespace

void DepthSettings::check() const {
  require(disparity_sigma_px > 0 && disparity_sigma_px < 10, ErrorCode::bad_input,
          "depth: disparity_sigma_px must lie in (0, 10)");
  require(footprint_m > 0 && footprint_m < 1, ErrorCode::bad_input, "depth: footprint_m must lie in (0, 1)");
  require(flying_window_px >= 1 && flying_window_px <= 31 && flying_window_px % 2 == 1, ErrorCode::bad_input,
          "depth: flying_window_px must be odd and in 1..31");
  require(flying_range_px > 0, ErrorCode::bad_input, "depth: flying_range_px must be positive");
}

int footprint_px(const StereoRig& rig, const DepthSettings& settings, double object_distance) {
  const double side = rig.camera.fx * settings.footprint_m / object_distance;
  return 2 * std::clamp(static_cast<int>(std::lround((side - 1) / 2)), 1, 15) + 1;
}

double depth_sigma(const StereoRig& rig, const DepthSettings& settings, double z) {
  return z * z * settings.disparity_sigma_px / (rig.camera.fx * rig.baseline);
}

object_model::DepthMap make_depth(const ImageF& disparity, const StereoRig& rig, const Pose& X_WC,
                                  const DepthSettings& settings, double object_distance) {
  settings.check();
  rig.check();
  require(disparity.channels == 1 && disparity.width == rig.camera.width && disparity.height == rig.camera.height,
          ErrorCode::bad_size, "the disparity map must have the camera's size");
  require(object_distance > 0, ErrorCode::bad_input, "the object's distance must be positive");
  const int w = disparity.width, h = disparity.height;
  const cv::Mat d(h, w, CV_32F, const_cast<float*>(disparity.data.data()));
  // The least depth is the greatest disparity; pixels without a match (0) never win.
  const cv::Mat nearest = box_filter(d, footprint_px(rig, settings, object_distance), true);
  const cv::Mat high = box_filter(d, settings.flying_window_px, true);
  cv::Mat present = d.clone();
  present.setTo(1e9f, d <= 0);
  const cv::Mat low = box_filter(present, settings.flying_window_px, false);

  object_model::DepthMap map{rig.camera, X_WC, ImageF(w, h), ImageF(w, h), ImageF(w, h)};
  const double fB = rig.camera.fx * rig.baseline;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const float here = disparity.at(x, y);
      if (here <= 0) continue;
      map.depth_minimum.at(x, y) = static_cast<float>(std::min(fB / nearest.at<float>(y, x), kFarthestDepth));
      if (high.at<float>(y, x) - low.at<float>(y, x) > settings.flying_range_px) continue;
      const double z = fB / here, sigma = depth_sigma(rig, settings, z);
      if (z > kFarthestDepth || sigma > kFarthestDepth) continue;
      map.depth.at(x, y) = static_cast<float>(z);
      map.depth_sigma.at(x, y) = static_cast<float>(sigma);
    }
  return map;
}

}  // namespace periplus::vision
