// The reference of visibility: one ray through each pixel's centre in double precision, after Amanatides and Woo (1987).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/voxel/visibility.h"

namespace periplus::voxel::testing {

// First occupied voxel on the ray p + t d (grid frame, voxels) that the camera at p is not in.
struct RayHit {
  Eigen::Vector3i voxel;
  double box_entry;  // t at which the ray enters the grid's box
};
std::optional<RayHit> cast_ray(const OccupancyGrid& grid, const Eigen::Vector3d& p, const Eigen::Vector3d& d);

struct RayCastView {
  std::map<std::uint32_t, std::uint32_t> unknown;  // pixels of each visible unknown voxel, by linear index
  std::uint64_t known = 0, environment = 0;        // pixels

  // N_u: unknown voxels with more pixels than that.
  std::size_t voxels(std::uint32_t more_than_pixels) const;
};

// `hidden`: whether something outside the grid hides what the ray from the camera along d_W (world frame, any length) meets from
// t = box_entry on.
using Hidden = std::function<bool(const Eigen::Vector3d& p_W, const Eigen::Vector3d& d_W, double box_entry)>;
RayCastView ray_cast(const OccupancyGrid& grid, const Pose& X_WC, const Pinhole& camera, const Hidden& hidden = {});

// Pixels on which the two disagree: counts of each unknown voxel, of known and of environment.
std::uint64_t difference(const RayCastView& expected, const VisibilityResult& result);

}  // namespace periplus::voxel::testing
