// How much of the true surface a run found, and how well: the yardstick of every claim. Shares no code with the planner.
//
// Samples lie area-uniform on the true surface (world frame, metres). A sample is
//   covered    if the centre of a known voxel lies within one voxel size of it, known meaning here that at least 3 valid depth
//              pixels of the looks so far fell into the voxel itself, whatever else made the model call it known;
//   reachable  if both cameras of the robot see it, within both images, at a depth that the pair measures, unoccluded, at <= 75
//              degrees from its normal, from at least one of the seeded poses whose head and floor box are free of collision, with
//              the object too;
//   visible    if it is unoccluded at <= 75 degrees from any place around it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"

namespace periplus::evaluation {

struct SurfaceSamples {
  std::vector<Eigen::Vector3d> points, normals;   // world, unit normals outwards
};

// Known voxels of a run: centres in the world.
struct KnownVoxels {
  double voxel_m = 0.01;
  std::vector<Eigen::Vector3d> centers;
};

// The grid of a look as grid.npy and grid.json tell it.
struct LookGrid {
  Pose X_WG = Pose::Identity();
  double voxel_m = 0.01;
  Eigen::Vector3i size{0, 0, 0};
  std::vector<std::uint8_t> states;   // x slowest, z fastest: 0 empty 1 unknown 2 known 3 environment
};
// Error(bad_input | io) for what is not such a file.
LookGrid read_grid(const std::string& look_folder);

// Counts over the looks of a run how many valid depth pixels fell into each voxel.
class DepthCount {
 public:
  // Adds depth.npy of the look at the pose and with the camera of its look.json. Where the grid is another than before (it grows with its
  // object), the looks before are counted again in this one.
  void add(const std::string& look_folder, const LookGrid& grid);
  // Known voxels of the grid that at least `least` depth pixels fell into.
  KnownVoxels known(const LookGrid& grid, int least = 3) const;

 private:
  void count(const std::string& look_folder, const LookGrid& grid);

  std::vector<std::string> looks_;
  Pose X_WG_ = Pose::Identity();                // of the grid counted in
  Eigen::Vector3i size_{0, 0, 0};
  std::vector<std::uint32_t> counts_;
};

struct ReachOptions {
  int poses = 5000;
  std::uint64_t seed = 1;
  double height_min = 1.0, height_max = 1.35;       // of the left eye [m]
  double distance_min = 0.6, distance_max = 2.5;    // to the nearest sample [m]
  double depth_min = 0.6, depth_max = 2.5;          // of a sample along the optical axis: what the pair measures [m]
  double pitch_min = -25, pitch_max = 60;           // [degrees], positive down
  double incidence_max = 75;                        // [degrees]
};

// What stands in the way: true if the straight line from p to q is blocked by the object or the scene.
using Blocked = std::function<bool(const Eigen::Vector3d& p, const Eigen::Vector3d& q)>;
// True if a robot whose left eye is at X_WC has its head and floor box free of collision.
using Stands = std::function<bool(const Pose& X_WC)>;

// True if a sample lies in the box (full side lengths) at X_WB.
bool box_holds_sample(const SurfaceSamples& samples, const Pose& X_WB, const Eigen::Vector3d& size);

// Camera poses that look at the samples from where the robot may stand; at most options.poses (fewer only where none is free
// in 200 times as many draws).
std::vector<Pose> reachable_poses(const SurfaceSamples& samples, const ReachOptions& options, const Stands& stands);
std::vector<bool> reachable_samples(const SurfaceSamples& samples, const StereoRig& rig, const std::vector<Pose>& poses,
                                    const ReachOptions& options, const Blocked& blocked);
// Tries `directions` seeded directions within the incidence cone of each sample, seen from 2 m away or, where a solid stands
// nearer, from 0.6 m.
std::vector<bool> visible_samples(const SurfaceSamples& samples, int directions, double incidence_max, std::uint64_t seed, const Blocked& blocked);
std::vector<bool> covered_samples(const SurfaceSamples& samples, const KnownVoxels& known);

// |covered and of| / |of|; 0 if `of` is empty.
double share(const std::vector<bool>& covered, const std::vector<bool>& of);

struct RunCoverage {
  double reachable = 0, visible = 0, all = 0;   // shares after the last look that could be read
  std::vector<std::string> skipped;             // a sentence for each look that could not
};
// Writes `coverage` and `coverage_visible` after each look into `looks` of a report.json (its files stand in
// run_folder/looks/NN). A look whose files are missing or damaged gets `coverage_error` instead and is left out.
RunCoverage cover_looks(const std::string& run_folder, nlohmann::json& looks, const SurfaceSamples& samples, const std::vector<bool>& reachable,
                        const std::vector<bool>& visible);

struct ErrorStatistics {
  double mean = 0, p95 = 0, max = 0;   // [m]
};
ErrorStatistics statistics(std::vector<double> distances);

}  // namespace periplus::evaluation
