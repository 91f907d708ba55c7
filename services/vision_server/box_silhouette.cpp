#include "services/vision_server/box_silhouette.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace periplus::vision {

ImageU8 box_silhouette(const Pinhole& camera, const Pose& X_WC, const object_model::ObjectBox& box, double grow) {
  ImageU8 mask(camera.width, camera.height);
  const Pose X_CB = X_WC.inverse() * box.X_WB;
  const Eigen::Vector3d half = box.size / 2 + Eigen::Vector3d::Constant(grow);
  std::vector<cv::Point2f> corners;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d p = X_CB * Eigen::Vector3d(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(),
                                                     i & 4 ? half.z() : -half.z());
    if (p.z() < 0.05) {
      std::fill(mask.data.begin(), mask.data.end(), std::uint8_t{255});
      return mask;
    }
    const Eigen::Vector2d uv = camera.project(p);
    corners.emplace_back(static_cast<float>(uv.x()), static_cast<float>(uv.y()));
  }
  std::vector<cv::Point2f> hull;
  cv::convexHull(corners, hull);
  std::vector<cv::Point> polygon;
  for (const cv::Point2f& p : hull)
    polygon.emplace_back(static_cast<int>(std::lround(std::clamp(p.x, -2e4f, 2e4f))),
                         static_cast<int>(std::lround(std::clamp(p.y, -2e4f, 2e4f))));
  cv::Mat view(mask.height, mask.width, CV_8UC1, mask.data.data());
  cv::fillConvexPoly(view, polygon, cv::Scalar(255));
  return mask;
}

ImageU8 hidden_from_right(const ImageF& disparity) {
  constexpr float kLeastStep = 2, kBlur = 4;  // [px]
  ImageU8 hidden(disparity.width, disparity.height);
  for (int y = 0; y < disparity.height; ++y) {
    int last = -1;  // last pixel with a disparity
    for (int x = 0; x < disparity.width; ++x) {
      if (disparity.at(x, y) <= 0) continue;
      if (last >= 0 && last < x - 1) {
        const float step = disparity.at(x, y) - disparity.at(last, y);
        if (step > kLeastStep && static_cast<float>(x - 1 - last) <= step + kBlur)
          std::fill(&hidden.at(last + 1, y), &hidden.at(x - 1, y) + 1, std::uint8_t{255});
      }
      last = x;
    }
  }
  return hidden;
}

double valid_share(const ImageF& disparity, const ImageU8& silhouette, double disparity_at_box) {
  require(disparity.width == silhouette.width && disparity.height == silhouette.height, ErrorCode::bad_size,
          "disparity map and silhouette must have one size");
  const ImageU8 hidden = hidden_from_right(disparity);
  std::int64_t all = 0, valid = 0;
  const int first = std::max(0, static_cast<int>(std::ceil(disparity_at_box)));
  for (int y = 0; y < disparity.height; ++y)
    for (int x = first; x < disparity.width; ++x) {
      if (!silhouette.at(x, y) || hidden.at(x, y)) continue;
      ++all;
      valid += disparity.at(x, y) > 0;
    }
  return all ? static_cast<double>(valid) / static_cast<double>(all) : 0;
}

bool on_known_solid(const scene::CollisionWorld* known, const Eigen::Vector3d& p_W) {
  return known && known->contains_or_floor(p_W, 0.01);
}

std::optional<ObjectShares> object_shares(const ImageF& disparity, const ImageF& filled, const ImageU8& textured, const StereoRig& rig,
                                          const Pose& X_WC, const object_model::ObjectBox& box,
                                          const scene::CollisionWorld* known) {
  require(disparity.width == filled.width && disparity.height == filled.height && disparity.width == textured.width && disparity.height == textured.height,
          ErrorCode::bad_size, "disparity map, filled map and texture must have one size");
  const ImageU8 silhouette = box_silhouette(rig.camera, X_WC, box);
  require(disparity.width == silhouette.width && disparity.height == silhouette.height, ErrorCode::bad_size,
          "the disparity map must have the camera's size");
  const Pose X_BW = box.X_WB.inverse();
  const auto is_object = [&](int x, int y) {
    const double d = filled.at(x, y);
    if (d <= 0 || !silhouette.at(x, y)) return false;
    const Eigen::Vector3d p_W = X_WC * rig.camera.back_project(x, y, rig.depth(d));
    return ((X_BW * p_W).cwiseAbs().array() <= box.size.array() / 2).all() && !on_known_solid(known, p_W);
  };
  const ImageU8 hidden = hidden_from_right(disparity);
  int object = 0, matched = 0, with_texture = 0;
  for (int y = 0; y < disparity.height; y += 2) {
    for (int x = 0; x < disparity.width; x += 2) {
      if (hidden.at(x, y) || !is_object(x, y)) continue;
      ++object;
      matched += disparity.at(x, y) > 0;
      with_texture += textured.at(x, y) != 0;
    }
  }
  if (object < 100) return std::nullopt;
  return ObjectShares{static_cast<double>(matched) / object, static_cast<double>(with_texture) / object};
}

std::optional<double> object_valid_share(const ImageF& disparity, const ImageF& filled, const StereoRig& rig,
                                         const Pose& X_WC, const object_model::ObjectBox& box,
                                         const scene::CollisionWorld* known) {
  const auto shares = object_shares(disparity, filled, ImageU8(disparity.width, disparity.height), rig, X_WC, box, known);
  if (!shares) return std::nullopt;
  return shares->valid;
}

}  // namespace periplus::vision
