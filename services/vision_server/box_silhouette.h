// The pixels that show the object's box, the object itself as far as it can be told, and how many of them were matched.
#pragma once

#include <optional>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/object_model/perception.h"
#include "common/scene/scene.h"

namespace periplus::vision {

// 255 within the convex hull of the box's projection into `camera` at X_WC, else 0; all 255 where a corner is nearer than
// 5 cm to the camera's plane. Sides are grown by `grow` [m] on each side.
ImageU8 box_silhouette(const Pinhole& camera, const Pose& X_WC, const object_model::ObjectBox& box, double grow = 0);

// 255 where the right eye cannot see past a nearer surface: gaps of the left eye's disparity no longer than the step up at
// their right end, and four pixels for the blur of matched blocks.
ImageU8 hidden_from_right(const ImageF& disparity);

// Share of the silhouette's pixels with a value > 0, counting only what the right eye can see as well: not what is hidden
// from it, nor what lies outside its picture at the box's distance; 0 if nothing is left. `disparity` belongs to the left eye.
double valid_share(const ImageF& disparity, const ImageU8& silhouette, double disparity_at_box);

// Share of matched pixels on the object: a box with a textured background looks well matched whatever stands in it. The
// object is where the filled disparity (disparity_filter.h) puts a point into the box and on no solid of `known` (may be
// nullptr). What is hidden from the right eye is not counted. Nothing if fewer than 100 pixels of every second row and column are the object.
std::optional<double> object_valid_share(const ImageF& disparity, const ImageF& filled, const StereoRig& rig,
                                         const Pose& X_WC, const object_model::ObjectBox& box,
                                         const scene::CollisionWorld* known);

// The same pixels, and beside the share of matched ones that of those where `textured` (texture.h) is not 0.
struct ObjectShares {
  double valid = 0, textured = 0;
};
std::optional<ObjectShares> object_shares(const ImageF& disparity, const ImageF& filled, const ImageU8& textured, const StereoRig& rig,
                                          const Pose& X_WC, const object_model::ObjectBox& box,
                                          const scene::CollisionWorld* known);

// True if the point belongs to a known solid: in it, or as near as stereo can tell (1 cm).
bool on_known_solid(const scene::CollisionWorld* known, const Eigen::Vector3d& p_W);

}  // namespace periplus::vision
