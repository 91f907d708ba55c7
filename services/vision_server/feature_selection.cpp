#include "services/vision_server/feature_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/error.h"
#include "common/object_model/descriptor_rows.h"
#include "services/vision_server/beside.h"

namespace periplus::vision {

namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

object_model::DescriptorRows rows_of(const DetectedFeatures& features) {
  object_model::DescriptorRows rows(features.kind);
  for (std::size_t i = 0; i < features.points.size(); ++i) rows.add(features.descriptor(i));
  return rows;
}

class Selector {
 public:
  // What is handed over stays the caller's.
  Selector(const DetectedFeatures& left, const DetectedFeatures& right, const object_model::DescriptorRows& left_rows,
           const object_model::DescriptorRows& right_rows, const SelectionSettings& s)
      : left_(left), right_(right), left_rows_(left_rows), right_rows_(right_rows), s_(s) {}

  // Same line, disparity and scale.
  bool may_be(const Keypoint& l, const Keypoint& r, double disparity) const {
    return std::abs(r.v - l.v) <= s_.stereo_px && std::abs(l.u - r.u - disparity) <= s_.stereo_px && r.size <= l.size * s_.scale_ratio && l.size <= r.size * s_.scale_ratio;
  }

  // Algorithm 4 for one left feature.
  bool geometry_first(std::size_t i, double disparity, SelectedFeature& out) {
    const Keypoint& l = left_.points[i];
    double best = kNone, second = kNone;
    // Right features are in ascending order of their rows.
    auto r = std::lower_bound(right_.points.begin(), right_.points.end(), l.v - s_.stereo_px - 1e-3, [](const Keypoint& k, double row) { return k.v < row; });
    for (; r != right_.points.end() && r->v <= l.v + s_.stereo_px + 1e-3; ++r) {
      if (!may_be(l, *r, disparity)) continue;
      const auto j = static_cast<std::size_t>(r - right_.points.begin());
      const double apart = object_model::descriptor_distance(left_.kind, left_.descriptor(i), right_.descriptor(j));
      if (apart < best) {
        second = best;
        best = apart;
        out.right = j;
      } else {
        second = std::min(second, apart);
      }
    }
    if (best == kNone) return false;
    out.distance = best;
    if (best > (object_model::is_binary(left_.kind) ? s_.most_bits : s_.most_distance)) return false;
    return best < s_.second_ratio * second;
  }

  // Algorithm 5 for one left feature.
  bool descriptor_first(std::size_t i, double disparity, SelectedFeature& out) {
    left_rows_.compare(i, right_rows_, apart_);
    const auto best = std::min_element(apart_.begin(), apart_.end());
    if (best == apart_.end()) return false;
    out.right = static_cast<std::size_t>(best - apart_.begin());
    out.distance = object_model::descriptor_distance(left_.kind, *best);
    return may_be(left_.points[i], right_.points[out.right], disparity);
  }

 private:
  const DetectedFeatures &left_, &right_;
  const object_model::DescriptorRows &left_rows_, &right_rows_;
  std::vector<std::uint32_t> apart_;
  const SelectionSettings& s_;
};

}  // namespace

void SelectionSettings::check() const {
  require(size_min_px >= 0 && size_max_px > size_min_px, ErrorCode::bad_input, "features: size_max_px must exceed size_min_px, and that must not be negative");
  require(response_min >= 0 && std::isfinite(response_min), ErrorCode::bad_input, "features: response_min must not be negative");
  require(stereo_px > 0 && scale_ratio >= 1, ErrorCode::bad_input, "features: stereo_px must be positive, scale_ratio at least 1");
  require(most_distance > 0 && most_distance <= 2 && most_bits > 0 && most_bits <= 1, ErrorCode::bad_input, "features: most_distance must lie in (0, 2], most_bits in (0, 1]");
  require(second_ratio > 0 && second_ratio <= 1, ErrorCode::bad_input, "features: second_ratio must lie in (0, 1]");
}

std::vector<SelectedFeature> select_features(const DetectedFeatures& left, const DetectedFeatures& right, const std::vector<double>& disparity,
                                             const SelectionSettings& settings) {
  settings.check();
  require(disparity.size() == left.points.size(), ErrorCode::bad_size, "each left feature needs a disparity");
  require(left.kind == right.kind || settings.method == FeatureSelection::left_alone, ErrorCode::bad_input, "both eyes need features of one kind");
  const object_model::DescriptorRows left_rows = rows_of(left), right_rows = rows_of(right);
  const auto select = [&](std::size_t begin, std::size_t end) {
    Selector selector(left, right, left_rows, right_rows, settings);
    std::vector<SelectedFeature> out;
    for (std::size_t i = begin; i < end; ++i) {
      const Keypoint& l = left.points[i];
      if (l.size <= settings.size_min_px || l.size >= settings.size_max_px || l.response < settings.response_min || !(disparity[i] > 0)) continue;
      SelectedFeature f{i, 0, disparity[i], 0};
      if (settings.method != FeatureSelection::left_alone) {
        if (settings.method == FeatureSelection::geometry_first ? !selector.geometry_first(i, disparity[i], f) : !selector.descriptor_first(i, disparity[i], f)) continue;
        f.disparity = l.u - right.points[f.right].u;
      }
      out.push_back(f);
    }
    return out;
  };
  const std::size_t half = left.points.size() / 2;
  auto lower = beside([&] { return select(half, left.points.size()); });
  std::vector<SelectedFeature> out = select(0, half);
  const std::vector<SelectedFeature> rest = lower.get();
  out.insert(out.end(), rest.begin(), rest.end());
  return out;
}

}  // namespace periplus::vision
