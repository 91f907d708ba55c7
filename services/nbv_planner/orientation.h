// Orientation is nearly free: what is visible from a place does not depend on where the camera looks. One wide rendering lists
// the unknown voxels that are visible; yaw, pitch and roll are then chosen on the list, without rendering again.
//
// World frame, metres, radians; pitch is positive down. Deterministic on every instruction set.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/visible_list_kernel.h"

namespace periplus::nbv {

// What both eyes' images contain within the depth range.
struct PairWindow {
  double tan_horizontal = 0, tan_vertical = 0;  // half angles of one eye
  double baseline = 0;                          // [m]
  double depth_min = 0.6, depth_max = 2.5;      // [m]

  static PairWindow of(const StereoRig& rig, const voxel::PairOptions& options);
  // Of a pair with that orientation.
  WindowPlanes planes(double yaw, double pitch, double roll = 0) const;
};

struct Angles {
  double yaw = 0, pitch = 0, roll = 0;
  Eigen::Vector3d forward() const;
};

// Left eye of a pair whose middle is at p_W, and back.
Pose left_eye(const Eigen::Vector3d& p_W, const Angles& angles, double baseline);
Eigen::Vector3d middle_of_eyes(const Pose& X_WC, double baseline);

// What is rendered for a list, and what its voxels stand for in the evaluator's grid.
class ListScene {
 public:
  // The evaluator's own scene.
  ListScene(const Evaluator& evaluator) : evaluator_(evaluator), scene_(evaluator.visibility()) {}  // NOLINT: the usual one
  // Of that grid coarsened once (voxel/coarsen.h): a voxel is worth four, which is how many of a surface it stands for.
  ListScene(const Evaluator& evaluator, const voxel::VisibilityScene& coarse) : evaluator_(evaluator), scene_(coarse), step_(2) {}

  const Evaluator& evaluator() const { return evaluator_; }
  const voxel::VisibilityScene& scene() const { return scene_; }
  double voxel_size() const { return scene_.geometry().voxel_size; }
  // Pixels of a voxel that is seen as large as one of the evaluator's with one pixel.
  int pixels() const { return step_ * step_; }
  // What seeing a voxel is worth.
  double weight(std::uint32_t voxel) const;
  // Calls with the evaluator's voxel and its pixels for each mark in a watched voxel.
  template <class Call>
  void for_each_mark(const voxel::VoxelPixels& v, const Call& call) const;

 private:
  template <class Call>
  void for_each_fine(std::uint32_t voxel, const Call& call) const;

  const Evaluator& evaluator_;
  const voxel::VisibilityScene& scene_;
  int step_ = 1;
};

// Points relative to a place, world axes [m], each with a weight.
class VisibleList {
 public:
  voxel::Simd simd = voxel::Simd::best;

  void clear() { size_ = 0; }
  int size() const { return size_; }
  void add(const Eigen::Vector3f& p, float weight = 1);
  // The voxels that a rendering lists, relative to p_W, each with its weight; where pixels are what counts
  // (Quantification), each with its pixels too, of which `scale` squared make one of the camera's.
  void take(std::span<const voxel::VoxelPixels> seen, double scale, const Eigen::Vector3d& p_W, const ListScene& of);
  // Those that both eyes' renderings list.
  void take_both(std::span<const voxel::VoxelPixels> left, std::span<const voxel::VoxelPixels> right, double scale, const Eigen::Vector3d& p_W,
                 const ListScene& of);

  // Sum of the weights of the points in the window.
  double sum(const WindowPlanes& window) const;
  // Mean of the points in the window; zero if there are none.
  Eigen::Vector3d mean(const WindowPlanes& window) const;
  Eigen::Vector3d point(int i) const { return Eigen::Vector3d(x_[i], y_[i], z_[i]); }

 private:
  friend class OrientationSearch;
  PointArrays arrays() const;
  void make_room(int size);
  void pad();
  // The first `count` of index_; their pixels in weight_.
  void place(int count, double scale, const Eigen::Vector3d& p_W, const ListScene& of);

  int size_ = 0;
  std::vector<float> x_, y_, z_;
  std::vector<std::int32_t> weight_;  // in 1/256
  std::vector<std::uint32_t> index_;
  std::vector<std::uint64_t> marked_;  // bit by voxel; all 0 between calls
};
// What else an orientation at a place costs: landmarks, forbidden poses, motion, reachability.
class OrientationCost {
 public:
  explicit OrientationCost(const Evaluator& evaluator);

  // The landmarks that a rendering saw from p_W; `scale` is the rendering's focal length by the camera's, `greatest` the largest
  // value met so far (3.2.1.5).
  void place(const Eigen::Vector3d& p_W, std::span<const voxel::VoxelPixels> watched, double scale, double greatest, const ListScene& of);
  // To be taken from the value of the list. 0 where there is nothing of the kind.
  double operator()(const Angles& angles, const WindowPlanes& window) const;

 private:
  struct Seen {
    Eigen::Vector3f p;
    double pixels;
    const Evaluator::Mark* mark;
  };
  const Evaluator& evaluator_;
  double greatest_ = 1;
  bool idle_ = false;
  Eigen::Vector3d p_W_ = Eigen::Vector3d::Zero();
  std::vector<Seen> landmarks_;
};

struct Aim {
  Angles angles;
  double value = 0;  // of the list, less the cost
};

// The best orientation for a list of points. Keeps its tables from call to call; one per thread.
class OrientationSearch {
 public:
  // Limits of yaw, pitch and roll as of the situation.
  OrientationSearch(const PairWindow& window, const robot::ViewLimits& limits) : window_(window), limits_(limits) {}

  // The best window of a histogram over azimuth and elevation in cells of 4 degrees, roll 0. An empty list: towards
  // `fallback`.
  Aim histogram(const VisibleList& list, const OrientationCost& cost, const Eigen::Vector3d& fallback);
  // Steps along yaw, pitch and (where the limits allow it) roll from `first` down to `last` [rad], each taken as long as it
  // makes the value greater.
  Aim compass(const VisibleList& list, const OrientationCost& cost, const Aim& start, double first, double last) const;
  // Compass searches from a few places around, since one alone ends at the first top.
  Aim kicks(const VisibleList& list, const OrientationCost& cost, const Aim& start, double last) const;
  Aim evaluate(const VisibleList& list, const OrientationCost& cost, Angles angles) const;
  const PairWindow& window() const { return window_; }

 private:
  Angles within_limits(Angles angles) const;

  PairWindow window_;
  robot::ViewLimits limits_;
  std::vector<float> azimuth_, elevation_;
  std::vector<double> sums_;
};

}  // namespace periplus::nbv
