// Visual features on the object's surface (thesis 4.2.2.1), each with its place, normal and size there.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/object_model/perception.h"
#include "common/scene/scene.h"
#include "services/vision_server/disparity_filter.h"
#include "services/vision_server/feature_detector.h"
#include "services/vision_server/feature_selection.h"

namespace periplus::vision {

struct FeatureSettings {
  DetectorSettings detector;
  SelectionSettings selection;
  int most = 600;              // kept features
  int cell_px = 32;            // they are spread: the strongest of each cell in turn
  double grow_box_m = 0.03;    // features this far outside the box still count as the object's
  bool on_filled = true;       // where the disparity is a guess too, if the right eye shows the feature there: placed by the two, not by the guess
  void check() const;          // throws Error(bad_input)
};

// Of the rectified grey right image, what the left eye's features may be found in: where the right eye's depth map `depth` shows the object, within
// the box and on no solid of `known` (may be nullptr); without a depth map (nullptr) where the box may be. None for left_alone. `X_WC`: the left eye.
// Deterministic, whatever cv::setNumThreads says. Throws Error(bad_size | bad_input).
DetectedFeatures find_right_features(const ImageU8& right, const StereoRig& rig, const Pose& X_WC, const object_model::DepthMap* depth,
                                     const object_model::ObjectBox& box, const scene::CollisionWorld* known, const FeatureSettings& settings);

// Features of the rectified grey left image that lie on the object: within the box and on no solid of `known` (may be nullptr), by
// the left eye's depth, or by a disparity of `filled` (may be empty) that is a guess. Of these, those that the selection keeps by what the right
// image shows (feature_selection.h): find_right_features(), which is asked for when the left eye's are there.
// Sorted by (v, u, size, angle). Deterministic, whatever cv::setNumThreads says. Throws Error(bad_size | bad_input), and what `right` throws.
std::vector<object_model::Feature> find_features(const ImageU8& left, const std::function<DetectedFeatures()>& right, const StereoRig& rig,
                                                 const object_model::DepthMap& depth, const FilledDisparity& filled,
                                                 const object_model::ObjectBox& box, const scene::CollisionWorld* known,
                                                 const FeatureSettings& settings);
// Both eyes at once. `depth`: the left eye's, and the right eye's where there is one.
std::vector<object_model::Feature> find_features(const ImageU8& left, const ImageU8& right, const StereoRig& rig,
                                                 std::span<const object_model::DepthMap> depth, const FilledDisparity& filled,
                                                 const object_model::ObjectBox& box, const scene::CollisionWorld* known,
                                                 const FeatureSettings& settings);

}  // namespace periplus::vision
