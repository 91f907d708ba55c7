// From disparity to depth that may be trusted: uncertainty, the least depth within a pixel's footprint (the conservative
// depth map that carving asks for, thesis 4.2.1.2), and no flying pixels.
#pragma once

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/object_model/perception.h"

namespace periplus::vision {

// [m] What lies further away has no depth, and as much for its least depth: that a perception can carry.
constexpr double kFarthestDepth = 100;

struct DepthSettings {
  double disparity_sigma_px = 0.4;   // standard deviation of a matched disparity; the eyes benchmark finds 0.34 with rich texture, 0.7 with weak
  double footprint_m = 0.003;        // side of the square, at the object's distance, whose least depth may carve
  int flying_window_px = 5;          // a surface is dropped where the disparity within this window ...
  double flying_range_px = 3;        // ... ranges over more than this
  void check() const;                // throws Error(bad_input)
};

// Of one eye: `disparity` [px], 0 where there is none; `X_WC` that eye's pose. `object_distance` [m] turns the footprint
// into pixels (3 to 31, odd).
//   depth          z = f B / d; 0 without a match and on flying pixels, which lie on no surface
//   depth_minimum  least z of the matched pixels in the footprint; 0 without a match. Flying pixels have it: behind
//                  their nearest neighbour nothing is claimed, in front of it space is free.
//   depth_sigma    depth_sigma(z), wherever depth is. Its minimum over the footprint is depth_sigma(depth_minimum): it grows with z
object_model::DepthMap make_depth(const ImageF& disparity, const StereoRig& rig, const Pose& X_WC,
                                  const DepthSettings& settings, double object_distance);

// Standard deviation of a depth z [m]: z^2 sigma_d / (f B).
double depth_sigma(const StereoRig& rig, const DepthSettings& settings, double z);

// Side of the footprint in pixels.
int footprint_px(const StereoRig& rig, const DepthSettings& settings, double object_distance);

}  // namespace periplus::vision
