#include "services/vision_server/features.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/features2d.hpp>
#include <tuple>

#include "services/vision_server/box_silhouette.h"
#include "services/vision_server/normals.h"

namespace periplus::vision {

namespace {

struct Found {
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
};

auto order_of(const cv::KeyPoint& k) { return std::make_tuple(k.pt.y, k.pt.x, k.size, k.angle); }

Found detect(const ImageU8& grey, const ImageU8& mask, const FeatureSettings& s) {
  const cv::Mat image(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data.data()));
  const cv::Mat where(mask.height, mask.width, CV_8UC1, const_cast<std::uint8_t*>(mask.data.data()));
  Found f;
  cv::SIFT::create(0, 3, s.contrast, s.edge, 1.6)->detectAndCompute(image, where, f.points, f.descriptors);
  return f;
}

// 255 where the depth puts a pixel into the box of half sides `half`, or a pixel's width beside it: descriptors are the greater part of the
// work, and background shows as many features as the object.
ImageU8 within_box(const object_model::DepthMap& map, const Pose& X_BW, const Eigen::Vector3d& half) {
  ImageU8 mask(map.depth.width, map.depth.height);
  const Pose X_BC = X_BW * map.X_WC;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const double z = map.depth.at(x, y);
      if (z <= 0) continue;
      const Eigen::Array3d p = (X_BC * map.camera.back_project(x, y, z)).cwiseAbs().array();
      if ((p <= half.array() + z / map.camera.fx).all()) mask.at(x, y) = 255;
    }
  return mask;
}

std::vector<std::uint8_t> root_sift(const cv::Mat& descriptors, int row) {
  const float* v = descriptors.ptr<float>(row);
  double sum = 1e-9;
  for (int i = 0; i < descriptors.cols; ++i) sum += v[i];
  std::vector<std::uint8_t> out(static_cast<std::size_t>(descriptors.cols));
  for (int i = 0; i < descriptors.cols; ++i)
    out[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::min<long>(255, std::lround(512 * std::sqrt(v[i] / sum))));
  return out;
}

// `right` in ascending order of rows.
bool confirmed_by(const std::vector<cv::KeyPoint>& right, const cv::KeyPoint& left, double disparity,
                  const FeatureSettings& s) {
  const auto above = [&](const cv::KeyPoint& r, double row) { return r.pt.y < row; };
  auto r = std::lower_bound(right.begin(), right.end(), left.pt.y - s.stereo_px - 1, above);
  for (; r != right.end() && r->pt.y <= left.pt.y + s.stereo_px + 1; ++r)
    if (std::abs(r->pt.y - left.pt.y) <= s.stereo_px && std::abs(left.pt.x - r->pt.x - disparity) <= s.stereo_px &&
        r->size <= left.size * s.scale_ratio && left.size <= r->size * s.scale_ratio)
      return true;
  return false;
}

// Indices of at most `most` points: the strongest of each cell, then the second of each, and so on.
std::vector<std::size_t> spread(const std::vector<cv::KeyPoint>& points, const std::vector<std::size_t>& candidates,
                                int cell, int most) {
  std::vector<std::size_t> by_strength = candidates;
  std::sort(by_strength.begin(), by_strength.end(), [&](std::size_t a, std::size_t b) {
    if (points[a].response != points[b].response) return points[a].response > points[b].response;
    return order_of(points[a]) < order_of(points[b]);
  });
  std::map<std::pair<int, int>, int> taken;
  std::vector<std::pair<int, std::size_t>> ranked;  // round in which it is taken, index
  for (std::size_t i : by_strength)
    ranked.emplace_back(
        taken[{static_cast<int>(points[i].pt.y) / cell, static_cast<int>(points[i].pt.x) / cell}]++, i);
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (ranked.size() > static_cast<std::size_t>(most)) ranked.resize(static_cast<std::size_t>(most));
  std::vector<std::size_t> out;
  for (const auto& [round, i] : ranked) out.push_back(i);
  std::sort(out.begin(), out.end(), [&](std::size_t a, std::size_t b) { return order_of(points[a]) < order_of(points[b]); });
  return out;
}

}  // namespace

void FeatureSettings::check() const {
  require(contrast > 0 && contrast < 1, ErrorCode::bad_input, "features: contrast must lie in (0, 1)");
  require(edge > 1, ErrorCode::bad_input, "features: edge must exceed 1");
  require(most >= 0 && most <= 8192, ErrorCode::bad_input, "features: most must lie in 0..8192");
  require(cell_px >= 1, ErrorCode::bad_input, "features: cell_px must be at least 1");
  require(size_min_px >= 0 && size_max_px > size_min_px, ErrorCode::bad_input,
          "features: size_max_px must exceed size_min_px, and that must not be negative");
  require(grow_box_m >= 0, ErrorCode::bad_input, "features: grow_box_m must not be negative");
  require(stereo_px > 0 && (scale_ratio == 0 || scale_ratio >= 1), ErrorCode::bad_input,
          "features: stereo_px must be positive, scale_ratio 0 (off) or at least 1");
}

std::vector<object_model::Feature> find_features(const ImageU8& left, const ImageU8& right, const StereoRig& rig,
                                                 const object_model::DepthMap& depth,
                                                 const object_model::ObjectBox& box, const scene::CollisionWorld* known,
                                                 const FeatureSettings& settings) {
  settings.check();
  const Pinhole& camera = rig.camera;
  require(left.width == camera.width && left.height == camera.height && left.channels == 1 &&
              depth.depth.width == camera.width && depth.depth.height == camera.height,
          ErrorCode::bad_size, "features need a grey image and a depth map of the camera's size");
  const Pose X_BW = box.X_WB.inverse();
  const Eigen::Vector3d half = box.size / 2 + Eigen::Vector3d::Constant(settings.grow_box_m);
  const Found found = detect(left, within_box(depth, X_BW, half), settings);
  std::vector<cv::KeyPoint> in_right;
  const bool check_right = !right.empty() && settings.scale_ratio > 0;
  if (check_right) {
    const Pose X_WR = depth.X_WC * Eigen::Translation3d(rig.baseline, 0, 0);
    const ImageU8 mask = box_silhouette(camera, X_WR, box, settings.grow_box_m + 0.01);
    const cv::Mat image(right.height, right.width, CV_8UC1, const_cast<std::uint8_t*>(right.data.data()));
    const cv::Mat where(mask.height, mask.width, CV_8UC1, const_cast<std::uint8_t*>(mask.data.data()));
    cv::SIFT::create(0, 3, settings.contrast / 2, settings.edge, 1.6)->detect(image, in_right, where);
    std::sort(in_right.begin(), in_right.end(), [](const cv::KeyPoint& a, const cv::KeyPoint& b) { return order_of(a) < order_of(b); });
  }

  std::vector<std::size_t> candidates;
  std::vector<Eigen::Vector3d> p_C(found.points.size());
  for (std::size_t i = 0; i < found.points.size(); ++i) {
    const cv::KeyPoint& k = found.points[i];
    if (k.size < settings.size_min_px || k.size > settings.size_max_px) continue;
    const int u = static_cast<int>(std::lround(k.pt.x)), v = static_cast<int>(std::lround(k.pt.y));
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    const double z = depth.depth.at(u, v);
    if (z <= 0) continue;
    p_C[i] = camera.back_project(k.pt.x, k.pt.y, z);
    const Eigen::Vector3d p_W = depth.X_WC * p_C[i];
    if (((X_BW * p_W).cwiseAbs().array() > half.array()).any() || on_known_solid(known, p_W)) continue;
    if (check_right && !confirmed_by(in_right, k, rig.disparity(z), settings)) continue;
    candidates.push_back(i);
  }

  std::vector<object_model::Feature> out;
  for (std::size_t i : spread(found.points, candidates, settings.cell_px, settings.most)) {
    const cv::KeyPoint& k = found.points[i];
    object_model::Feature f;
    f.u = k.pt.x;
    f.v = k.pt.y;
    f.size = k.size;
    f.angle = static_cast<float>(k.angle * M_PI / 180);
    f.p_W = depth.X_WC * p_C[i];
    f.size_m = k.size * p_C[i].z() / camera.fx;
    const int half_window = std::clamp(static_cast<int>(k.size / 2), kNormalHalfWindow, 12);
    if (const auto n = normal_at(depth.depth, camera, static_cast<int>(std::lround(k.pt.x)),
                                 static_cast<int>(std::lround(k.pt.y)), half_window, kNormalReach))
      f.normal_W = depth.X_WC.linear() * *n;
    f.descriptor = root_sift(found.descriptors, static_cast<int>(i));
    out.push_back(std::move(f));
  }
  return out;
}

}  // namespace periplus::vision
