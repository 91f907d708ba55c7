// Depth map based space carving (thesis 4.2.1.4, Algorithm 3), conservative.
//
// A voxel is shown to be empty by a depth map if all pixels of its projection carry a depth that lies beyond the voxel's
// centre by more than a margin. The thesis' margin is half a voxel; half a voxel's diagonal (0.87) is the least that
// empties no voxel which the surface touches, as long as the depths are exact. Depths are along the optical axis.
//
// Which pixels carve, and how far:
//   valid                    to the least depth within the pixel's footprint (DepthMap::depth_minimum)
//   valid, on a known solid  `solid_extra_voxels` further, so that no layer stays standing on the table; no further where it is the
//                            floor's to within the depth's uncertainty alone: it may as well stand there
//   without depth            never; but a gap of at most `gap_px` carves to the least of its four neighbours, unless the
//                            view is cautious
//
// A view is cautious when less than `cautious_share` of the object's silhouette has a depth, or when its pose is uncertain: no gap is
// closed then, and what it shows to be empty is emptied only with the vote of another depth map. With an uncertain pose the margin is
// wider besides.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/geometry/image.h"
#include "common/object_model/perception.h"
#include "common/voxel/occupancy_grid.h"
#include "common/voxel/visibility.h"

namespace periplus::scene {
class CollisionWorld;
}

namespace periplus::object_model {

// `conservative`: one depth map empties a voxel for good, within the rules above. `probabilistic`: depth maps outvote each other (log_odds.h).
enum class CarvingMode { conservative, probabilistic };

// Of the probabilistic mode.
struct LogOddsSettings {
  double hit = 0.85, miss = -0.4;     // log-odds of one depth map (OctoMap's)
  double least = -2, most = 3.5;      // where they stop
  double empty_below = -0.6;          // more than one depth map's miss
  double known_above = 0.4;
  double disparity_sigma_px = 0.5;    // standard deviation of a matched disparity [px]
  double support_share = 0.25;        // of the depths within two pixels that must be like a pixel's for it to count ...
  double support_voxels = 1;          // ... to within this [voxels]
  bool operator==(const LogOddsSettings&) const = default;
};

struct CarvingSettings {
  CarvingMode mode = CarvingMode::conservative;
  double margin_voxels = 0.87;        // beyond the voxel's centre [voxels]
  int gap_px = 8;                     // longest gap that is closed [px]
  double cautious_share = 0.8;        // of the silhouette with a depth, below which a view is cautious
  int cautious_votes = 2;             // depth maps that must agree before a cautious view empties a voxel
  double uncertain_pose_m = 0.0025;   // standard deviation of where the object is seen, from which on a pose is uncertain [m] ...
  double uncertain_pose_voxels = 0.3; // ... and no less than this [voxels]
  double uncertain_margin_voxels = 1.5;
  double solid_extra_voxels = 1.5;    // [voxels]
  double solid_tolerance_m = 0.004;   // a point this close to a known solid is that solid's [m]
  int known_points = 3;               // depth points within a voxel that make it known
  int seen_points = 10;               // depth points closely behind a voxel that make it known
  double truncation_voxels = 3;       // of the signed distance [voxels]
  LogOddsSettings log_odds;

  // Throws Error(bad_input) naming the value and its range.
  void check() const;
  bool operator==(const CarvingSettings&) const = default;
};

// How the depth maps of one view may carve.
struct CarvingRule {
  double margin_voxels = 0.87;
  bool close_gaps = true;
  int votes = 1;             // depth maps that must show a voxel to be empty
  double pose_sigma_m = 0;   // standard deviation of where a point on the object is seen, in one direction
};

// Standard deviation [m], in the worst direction, of a point `distance` [m] from a camera whose position [m] and rotation [rad] have this
// covariance (both in one frame, any; position first).
double point_sigma(const Eigen::Matrix<double, 6, 6>& pose_covariance, double distance);
// `silhouette_valid_share`: Perception's; `pose_sigma_m`: point_sigma() at the object.
CarvingRule carving_rule(double silhouette_valid_share, double pose_sigma_m, double voxel_size, const CarvingSettings& settings);

enum class PixelKind : std::uint8_t { none = 0, surface = 1, known_solid = 2 };

// How far each pixel carves [m] (0: not at all) and what it shows. `limit` has the size of the depth map.
struct PixelLimits {
  ImageF limit;
  Image<PixelKind> kind;
};

// `known` may be null: no known solids. Throws Error(bad_size) if the images do not fit the camera.
PixelLimits pixel_limits(const DepthMap& map, const voxel::GridGeometry& geometry, const CarvingSettings& settings, bool closes_gaps,
                         const scene::CollisionWorld* known);

// Plane (layout of OccupancyGrid) of the occupied voxels, environment left out, that the limits show to be empty: those of Algorithm 3,
// but for a few whose projection ends within rounding of a pixel's border. Brick by brick where one answer holds for a whole brick, else in
// single precision, rounded towards leaving a voxel standing. The same bits for any `simd`.
// Throws Error(bad_size) if the limits do not fit the camera.
std::vector<std::uint64_t> seen_through(const voxel::OccupancyGrid& grid, const Pinhole& camera, const Pose& X_WC, const ImageF& limit,
                                        double margin_voxels, voxel::Simd simd = voxel::Simd::best);

// The same in pieces, for several threads at a time: each works until nothing is left to do, and the last one's end completes the plane.
class SeenThrough {
 public:
  // What is handed over stays the caller's. Throws Error(bad_size) if the limits do not fit the camera.
  SeenThrough(const voxel::OccupancyGrid& grid, const Pinhole& camera, const Pose& X_WC, const ImageF& limit, double margin_voxels,
              voxel::Simd simd = voxel::Simd::best);
  ~SeenThrough();
  void work();

  std::vector<std::uint64_t> plane;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::object_model
