#include "services/vision_server/features.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <utility>

#include "services/vision_server/beside.h"
#include "services/vision_server/box_silhouette.h"
#include "services/vision_server/normals.h"

namespace periplus::vision {

namespace {

constexpr double kRightSensitivity = 2;      // of the right eye: what is faint in one is fainter in the other
constexpr double kLeastDisparity = 0.5;      // [px]

constexpr int kRim = 3, kGap = 7;            // [px] around the object's pixels: of the left eye, and of the right one, whose gaps are not filled

// The box, grown, as an eye at X_WC sees it.
class GrownBox {
 public:
  GrownBox(const object_model::ObjectBox& box, double grow, const Pose& X_WC) : X_BC_(box.X_WB.inverse() * X_WC), half_(box.size / 2 + Eigen::Vector3d::Constant(grow)) {}
  bool holds(const Eigen::Vector3d& p_C) const { return ((X_BC_ * p_C).cwiseAbs().array() <= half_.array()).all(); }

 private:
  Pose X_BC_;
  Eigen::Vector3d half_;
};

// 255 where `depth_at(x, y)` [m, 0: none] puts every second pixel each way into the box and on no known solid, and `reach` pixels
// around: descriptors are the greater part of the work, and background and table show as many features as the object.
template <class DepthAt>
ImageU8 mask_of(const Pinhole& camera, const Pose& X_WC, const GrownBox& box, const scene::CollisionWorld* known, int reach, DepthAt&& depth_at) {
  ImageU8 out(camera.width, camera.height);
  for (int y = 0; y < out.height; y += 2)
    for (int x = 0; x < out.width; x += 2) {
      const double z = depth_at(x, y);
      if (z <= 0) continue;
      const Eigen::Vector3d p_C = camera.back_project(x, y, z);
      if (box.holds(p_C) && !on_known_solid(known, X_WC * p_C)) out.at(x, y) = 255;
    }
  const cv::Mat view(out.height, out.width, CV_8UC1, out.data.data());
  cv::dilate(view, view, cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1}));
  return out;
}

struct Sight {
  double z = 0;          // [m], 0: nothing
  bool guessed = false;
};

// Indices into `chosen` of at most `most`: the strongest of each cell, then the second of each, and so on; in the order of `chosen`.
std::vector<std::size_t> spread(const std::vector<Keypoint>& points, const std::vector<SelectedFeature>& chosen, int cell, int most) {
  std::vector<std::size_t> by_strength(chosen.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) by_strength[i] = i;
  std::stable_sort(by_strength.begin(), by_strength.end(),
                   [&](std::size_t a, std::size_t b) { return points[chosen[a].left].response > points[chosen[b].left].response; });
  std::map<std::pair<int, int>, int> taken;
  std::vector<std::pair<int, std::size_t>> ranked;  // round in which it is taken, index
  for (const std::size_t i : by_strength) {
    const Keypoint& k = points[chosen[i].left];
    ranked.emplace_back(taken[{static_cast<int>(k.v) / cell, static_cast<int>(k.u) / cell}]++, i);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (ranked.size() > static_cast<std::size_t>(most)) ranked.resize(static_cast<std::size_t>(most));
  std::vector<std::size_t> out;
  for (const auto& [round, i] : ranked) out.push_back(i);
  std::sort(out.begin(), out.end());
  return out;
}

template <class Picture>
bool fits(const Picture& image, const Pinhole& camera) {
  return image.width == camera.width && image.height == camera.height && image.channels == 1;
}

}  // namespace

void FeatureSettings::check() const {
  detector.check();
  selection.check();
  require(most >= 0 && most <= 8192, ErrorCode::bad_input, "features: most must lie in 0..8192");
  require(cell_px >= 1, ErrorCode::bad_input, "features: cell_px must be at least 1");
  require(grow_box_m >= 0, ErrorCode::bad_input, "features: grow_box_m must not be negative");
}

DetectedFeatures find_right_features(const ImageU8& right, const StereoRig& rig, const Pose& X_WC, const object_model::DepthMap* depth,
                                     const object_model::ObjectBox& box, const scene::CollisionWorld* known, const FeatureSettings& settings) {
  settings.check();
  require(fits(right, rig.camera) && (!depth || fits(depth->depth, rig.camera)), ErrorCode::bad_size,
          "features need grey images and depth maps of the camera's size");
  if (settings.selection.method == FeatureSelection::left_alone) return {settings.detector.kind, {}, {}};
  const Pose X_WR = X_WC * Eigen::Translation3d(rig.baseline, 0, 0);
  const ImageU8 mask = depth ? mask_of(rig.camera, X_WR, GrownBox(box, settings.grow_box_m, X_WR), known, kGap, [&](int x, int y) { return depth->depth.at(x, y); })
                             : box_silhouette(rig.camera, X_WR, box, settings.grow_box_m + 0.01);
  return detect_features(right, mask, settings.detector, kRightSensitivity);
}

std::vector<object_model::Feature> find_features(const ImageU8& left, const ImageU8& right, const StereoRig& rig,
                                                 std::span<const object_model::DepthMap> depth, const FilledDisparity& filled,
                                                 const object_model::ObjectBox& box, const scene::CollisionWorld* known,
                                                 const FeatureSettings& settings) {
  require(!depth.empty(), ErrorCode::bad_size, "features need the left eye's depth map");
  auto of_right = beside([&] { return find_right_features(right, rig, depth[0].X_WC, depth.size() > 1 ? &depth[1] : nullptr, box, known, settings); });
  return find_features(left, [&] { return of_right.get(); }, rig, depth[0], filled, box, known, settings);
}

std::vector<object_model::Feature> find_features(const ImageU8& left, const std::function<DetectedFeatures()>& right, const StereoRig& rig,
                                                 const object_model::DepthMap& depth, const FilledDisparity& filled,
                                                 const object_model::ObjectBox& box, const scene::CollisionWorld* known,
                                                 const FeatureSettings& settings) {
  settings.check();
  const Pinhole& camera = rig.camera;
  require(fits(left, camera) && fits(depth.depth, camera) && (filled.disparity.empty() || (fits(filled.disparity, camera) && fits(filled.filled, camera))),
          ErrorCode::bad_size, "features need grey images, depth maps and disparities of the camera's size");
  const bool pair = settings.selection.method != FeatureSelection::left_alone;
  const GrownBox grown(box, settings.grow_box_m, depth.X_WC);
  const bool use_filled = settings.on_filled && pair && !filled.disparity.empty();
  const auto sight = [&](int x, int y) -> Sight {
    if (const double z = depth.depth.at(x, y); z > 0) return {z, false};
    if (use_filled && filled.filled.at(x, y)) return {rig.depth(filled.disparity.at(x, y)), true};
    return {};
  };
  const DetectedFeatures found = detect_features(left, mask_of(camera, depth.X_WC, grown, known, kRim, [&](int x, int y) { return sight(x, y).z; }), settings.detector);

  const auto on_object = [&](const Eigen::Vector3d& p_C) { return grown.holds(p_C) && !on_known_solid(known, depth.X_WC * p_C); };
  std::vector<double> disparity(found.points.size());
  std::vector<Sight> sights(found.points.size());
  for (std::size_t i = 0; i < found.points.size(); ++i) {
    const Keypoint& k = found.points[i];
    const int u = static_cast<int>(std::lround(k.u)), v = static_cast<int>(std::lround(k.v));
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    sights[i] = sight(u, v);
    if (sights[i].z > 0 && on_object(camera.back_project(k.u, k.v, sights[i].z))) disparity[i] = rig.disparity(sights[i].z);
  }
  std::vector<SelectedFeature> chosen = select_features(found, right(), disparity, settings.selection);
  // A guess has told where to look; the place is where both eyes see the feature.
  std::erase_if(chosen, [&](const SelectedFeature& c) {
    const Keypoint& k = found.points[c.left];
    Sight& seen = sights[c.left];
    if (!seen.guessed) return false;
    if (c.disparity < kLeastDisparity) return true;
    seen.z = rig.depth(c.disparity);
    return !on_object(camera.back_project(k.u, k.v, seen.z));
  });

  std::vector<object_model::Feature> out;
  for (const std::size_t i : spread(found.points, chosen, settings.cell_px, settings.most)) {
    const std::size_t at = chosen[i].left;
    const Keypoint& k = found.points[at];
    object_model::Feature f;
    f.u = k.u;
    f.v = k.v;
    f.size = k.size;
    f.angle = k.angle;
    const Eigen::Vector3d p_C = camera.back_project(k.u, k.v, sights[at].z);
    f.p_W = depth.X_WC * p_C;
    f.size_m = k.size * p_C.z() / camera.fx;
    const int half_window = std::clamp(static_cast<int>(k.size / 2), kNormalHalfWindow, 12);
    if (const auto n = normal_at(depth.depth, camera, static_cast<int>(std::lround(k.u)), static_cast<int>(std::lround(k.v)), half_window, kNormalReach))
      f.normal_W = depth.X_WC.linear() * *n;
    f.kind = found.kind;
    const auto descriptor = found.descriptor(at);
    f.descriptor.assign(descriptor.begin(), descriptor.end());
    out.push_back(std::move(f));
  }
  return out;
}

}  // namespace periplus::vision
