// Which disparities to search: from the walls of the known room to whatever stands nearest in the picture. The box's own
// range would not do: pixels beyond it have to be seen as free, and would be matched wrongly into the box.
#pragma once

#include <limits>

#include "common/geometry/camera.h"
#include "common/object_model/perception.h"
#include "common/scene/scene.h"
#include "services/vision_server/stereo_matcher.h"

namespace periplus::vision {

// Depths along the optical axis [m].
struct DepthRange {
  double nearest = 0, farthest = 0;
  double box = std::numeric_limits<double>::infinity();  // nearest of the object's box
};

// Of the box, the part of the known solids and floor within the picture, and the room, from the left eye at X_WC. Never
// nearer than `least_depth`, which bounds the work. Without a scene, `farthest` is `default_far`.
DepthRange depth_range(const StereoRig& rig, const Pose& X_WC, const object_model::ObjectBox& box,
                       const scene::Scene* scene, double least_depth, double default_far);

// The disparities of those depths, one pixel wider on both sides, rounded up to a multiple of 16; at most kMostDisparity. Throws
// Error(vision_no_depth) where the box would have more.
DisparityRange disparity_range(const StereoRig& rig, const DepthRange& depths);

}  // namespace periplus::vision
