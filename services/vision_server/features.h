// Visual features on the object's surface (thesis 4.2.2.1): SIFT (Lowe 2004) with RootSIFT descriptors (Arandjelovic and
// Zisserman 2012), each with its place, normal and size on the surface.
#pragma once

#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/object_model/perception.h"
#include "common/scene/scene.h"

namespace periplus::vision {

struct FeatureSettings {
  double contrast = 0.02;      // SIFT's contrast threshold
  double edge = 12;            // SIFT's edge threshold
  int most = 600;              // kept features
  int cell_px = 32;            // they are spread: the strongest of each cell in turn
  double size_min_px = 2;      // s_min, s_max of thesis Algorithms 4 and 5
  double size_max_px = 60;
  double grow_box_m = 0.03;    // features this far outside the box still count as the object's
  double stereo_px = 1.5;      // the right eye must show a feature of like scale this near to where the disparity puts it
  double scale_ratio = 1.5;    // like scale; 0 switches the check in the right image off
  void check() const;          // throws Error(bad_input)
};

// Features of the rectified grey left image whose pixel has depth within the box and on no solid of `known` (may be
// nullptr); with `right` not empty, only those that
// the right image confirms: same line, disparity and scale (thesis Algorithm 5). Sorted by (v, u, size, angle).
// Descriptors: 128 bytes, 512 times RootSIFT, clamped. Deterministic.
std::vector<object_model::Feature> find_features(const ImageU8& left, const ImageU8& right, const StereoRig& rig,
                                                 const object_model::DepthMap& depth,
                                                 const object_model::ObjectBox& box, const scene::CollisionWorld* known,
                                                 const FeatureSettings& settings);

}  // namespace periplus::vision
