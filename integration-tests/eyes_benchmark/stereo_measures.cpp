#include "integration-tests/eyes_benchmark/stereo_measures.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/core/error.h"
#include "services/vision_server/normals.h"

namespace periplus::eyes_benchmark {
namespace {

double ratio(std::size_t part, std::size_t whole) { return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole); }

template <class A, class B>
void same_size(const A& a, const B& b) {
  require(a.width == b.width && a.height == b.height && a.channels == 1 && b.channels == 1, ErrorCode::bad_size, "maps to be compared must have one size");
}

}  // namespace

Spread spread(std::vector<double> values) {
  Spread s;
  s.count = values.size();
  if (values.empty()) return s;
  std::sort(values.begin(), values.end());
  const auto at = [&](double q) { return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))]; };
  s.mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  s.median = at(0.5);
  s.p95 = at(0.95);
  return s;
}

void StereoTally::add(const ImageF& matched, const ImageF& surface, const ImageF& carved, const ImageF& truth, const ImageU8& object, const StereoRig& rig) {
  same_size(matched, truth);
  same_size(object, truth);
  if (!surface.empty()) same_size(surface, truth);
  if (!carved.empty()) same_size(carved, truth);
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    if (!object.data[i]) continue;
    ++pixels_;
    const double z = truth.data[i], d = matched.data[i];
    surface_ += !surface.empty() && surface.data[i] > 0;
    behind_ += !carved.empty() && carved.data[i] > z + kBehind;
    if (d <= 0) continue;
    ++matched_;
    const double wrong = std::abs(d - rig.disparity(z));
    bad_1_ += wrong > 1;
    bad_2_ += wrong > 2;
    if (wrong <= 2) squares_ += wrong * wrong;
    errors_.push_back(std::abs(rig.depth(d) - z));
  }
}

StereoQuality StereoTally::quality() const {
  StereoQuality q;
  q.pixels = pixels_;
  q.valid = ratio(matched_, pixels_);
  q.surface = ratio(surface_, pixels_);
  q.bad_1 = ratio(bad_1_, matched_);
  q.bad_2 = ratio(bad_2_, matched_);
  if (matched_ > bad_2_) q.sigma_px = std::sqrt(squares_ / static_cast<double>(matched_ - bad_2_));
  q.behind = ratio(behind_, pixels_);
  q.error = spread(errors_);
  return q;
}

ImageF least_within(const ImageF& image, int side) {
  require(side >= 1 && side % 2 == 1, ErrorCode::bad_input, "the side of a square about a pixel must be odd");
  const int r = side / 2;
  ImageF rows(image.width, image.height), out(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      float least = image.at(x, y);
      for (int u = std::max(0, x - r); u <= std::min(image.width - 1, x + r); ++u) least = std::min(least, image.at(u, y));
      rows.at(x, y) = least;
    }
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      float least = rows.at(x, y);
      for (int v = std::max(0, y - r); v <= std::min(image.height - 1, y + r); ++v) least = std::min(least, rows.at(x, v));
      out.at(x, y) = least;
    }
  return out;
}

void add_normal_errors(const ImageF& depth, const ImageU8& object, const Pinhole& camera, const Pose& X_WC, const mesh::TriangleMesh& mesh_W,
                       const mesh::TriangleTree& tree, int step, NormalErrors& errors) {
  same_size(depth, object);
  for (int v = 0; v < depth.height; v += step)
    for (int u = 0; u < depth.width; u += step) {
      if (!object.at(u, v) || depth.at(u, v) <= 0) continue;
      const Eigen::Vector3d ray = X_WC.linear() * camera.back_project(u, v, 1);
      const auto hit = tree.ray(X_WC.translation(), ray);
      if (!hit) continue;
      ++errors.tried;
      const auto n = vision::normal_at(depth, camera, u, v, vision::kNormalHalfWindow, vision::kNormalReach);
      if (!n) continue;
      const Eigen::Vector3i& t = mesh_W.triangles[static_cast<std::size_t>(hit->triangle)];
      const auto corner = [&](int i) { return mesh_W.vertices[static_cast<std::size_t>(t[i])]; };
      Eigen::Vector3d face = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
      if (face.dot(ray) > 0) face = -face;
      errors.angles.push_back(std::acos(std::clamp(face.dot(X_WC.linear() * *n), -1.0, 1.0)));
    }
}

DisparityQuality disparity_quality(const ImageF& disparity, const ImageF& truth, int first_column) {
  same_size(disparity, truth);
  std::size_t pixels = 0, matched = 0, bad_1 = 0, bad_2 = 0;
  for (int y = 0; y < truth.height; ++y)
    for (int x = std::max(0, first_column); x < truth.width; ++x) {
      if (truth.at(x, y) <= 0) continue;
      ++pixels;
      if (disparity.at(x, y) <= 0) continue;
      ++matched;
      const double wrong = std::abs(disparity.at(x, y) - truth.at(x, y));
      bad_1 += wrong > 1;
      bad_2 += wrong > 2;
    }
  return {pixels, ratio(matched, pixels), ratio(bad_1, matched), ratio(bad_2, matched)};
}

DisparityQuality quality_where_both(const ImageF& disparity, const ImageF& other, const ImageF& truth, int first_column) {
  same_size(disparity, other);
  ImageF both = disparity;
  for (std::size_t i = 0; i < both.data.size(); ++i)
    if (other.data[i] <= 0) both.data[i] = 0;
  return disparity_quality(both, truth, first_column);
}

}  // namespace periplus::eyes_benchmark
