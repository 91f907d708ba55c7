// Surface normals from a depth map.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"

namespace periplus::vision {

// Half side of the least window [px] over which stereo leaves a normal good to ten degrees, and depth steps [m] that end a surface. Pixels, for
// the noise of depth grows with the square of the distance, the window's width on the surface with the distance.
inline constexpr int kNormalHalfWindow = 7;
inline constexpr double kNormalReach = 0.03;

// Normal in the camera's frame, unit, towards the camera, at pixel (u, v): of the plane fitted to the points of the
// (2 half_window + 1)^2 pixels around it that lie within `reach` [m] of it in depth (least squares by the smallest principal
// axis). Nothing where the pixel has no depth, fewer than a third of the window agree, or the points are no plane.
std::optional<Eigen::Vector3d> normal_at(const ImageF& depth, const Pinhole& camera, int u, int v, int half_window,
                                         double reach);

}  // namespace periplus::vision
