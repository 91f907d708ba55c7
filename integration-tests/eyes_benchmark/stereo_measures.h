// How well an eye's depth agrees with the truth: each measure over many pixels and views.
//
// Disparities and depths are 0 where there is none. Lengths in metres, disparities in pixels, shares 0..1.
#pragma once

#include <numbers>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "common/mesh/triangle_tree.h"

namespace periplus::eyes_benchmark {

inline constexpr double kDegrees = 180 / std::numbers::pi;  // of a radian

struct Spread {
  double mean = 0, median = 0, p95 = 0;
  std::size_t count = 0;
};
// Quantile q of n values: the one of rank floor(q (n - 1)). All 0 of none.
Spread spread(std::vector<double> values);

struct StereoQuality {
  std::size_t pixels = 0;       // of the object
  double valid = 0;             // share of them that is matched
  double surface = 0;           // that keeps a depth without flying pixels
  double bad_1 = 0, bad_2 = 0;  // share of the matched ones whose disparity is wrong by more than 1, 2 px
  double sigma_px = 0;          // root mean square of the other ones' disparity errors, up to 2 px
  Spread error;                 // |depth - truth| of the matched ones [m]
  double behind = 0;            // share of the object's pixels where space is carved more than kBehind behind the truth
};
inline constexpr double kBehind = 0.005;  // [m]

class StereoTally {
 public:
  // One view. `matched` [px] as the matcher gives it; `surface` the depth without flying pixels, may be empty; `carved` how far
  // each pixel's surroundings carve, may be empty; `object` not 0 where the object is seen. Throws Error(bad_size) for images of
  // different sizes.
  void add(const ImageF& matched, const ImageF& surface, const ImageF& carved, const ImageF& truth, const ImageU8& object, const StereoRig& rig);
  StereoQuality quality() const;

 private:
  std::size_t pixels_ = 0, matched_ = 0, surface_ = 0, bad_1_ = 0, bad_2_ = 0, behind_ = 0;
  double squares_ = 0;  // of disparity errors up to 2 px
  std::vector<double> errors_;
};

// Least value within the square of `side` (odd) pixels around each; 0, no depth, is the least. Beyond the border is nothing.
ImageF least_within(const ImageF& image, int side);

// Angles [rad] between the normals of vision::normal_at with the window that features have at least, and the mesh's faces, at every
// `step`-th pixel of the object each way. `tried` counts pixels with a depth.
struct NormalErrors {
  std::vector<double> angles;
  std::size_t tried = 0;
};
void add_normal_errors(const ImageF& depth, const ImageU8& object, const Pinhole& camera, const Pose& X_WC, const mesh::TriangleMesh& mesh_W,
                       const mesh::TriangleTree& tree, int step, NormalErrors& errors);

// Disparities against true ones, of whole images: pixels with a truth (> 0) and x >= `first_column`.
struct DisparityQuality {
  std::size_t pixels = 0;
  double covered = 0;           // share of them that is matched
  double bad_1 = 0, bad_2 = 0;  // share of the matched ones that is wrong by more than 1, 2 px
};
DisparityQuality disparity_quality(const ImageF& disparity, const ImageF& truth, int first_column);
// The same of `disparity` alone, over those pixels where `other` has a value too.
DisparityQuality quality_where_both(const ImageF& disparity, const ImageF& other, const ImageF& truth, int first_column);

}  // namespace periplus::eyes_benchmark
