// The object as obstacle: everything of its grid that is occupied and not the environment's, unknown voxels included.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/voxel/occupancy_grid.h"

namespace periplus::posture {

// Spheres about coarse cells of the grid: each holds its cell, so that nothing occupied lies outside.
class ObjectObstacle {
 public:
  ObjectObstacle() = default;   // nothing
  // `cell_size` [m] is rounded to whole voxels, at least one.
  ObjectObstacle(const voxel::OccupancyGrid& grid, double cell_size);

  struct Nearest {
    double distance = 0;           // from the axis to the sphere's surface [m]; negative inside
    Eigen::Vector3d on_axis, center;
  };
  // Of the segment a-b; distance = range where nothing is nearer.
  Nearest nearest(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double range) const;

  bool empty() const { return centers_.empty(); }
  double radius() const { return radius_; }
  const std::vector<Eigen::Vector3d>& centers() const { return centers_; }

 private:
  std::vector<Eigen::Vector3d> centers_;   // of cells with a free neighbour [m]
  double radius_ = 0;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();  // sphere about all centres
  double reach_ = 0;
};

}  // namespace periplus::posture
