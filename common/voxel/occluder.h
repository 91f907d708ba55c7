// Solids outside of the grid that hide what is behind them. World frame W, metres.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry/pose.h"

namespace periplus::voxel {

// A convex solid of the known environment, as points whose convex hull it is (of three points: a triangle).
struct Occluder {
  std::vector<Eigen::Vector3d> points_W;

  // Box with its centre at X_WS; full side lengths.
  static Occluder box(const Pose& X_WS, const Eigen::Vector3d& size);
  // Cylinder about the z axis of X_WS, centre at its origin: a prism of 64 sides of the same cross-section area.
  static Occluder cylinder(const Pose& X_WS, double diameter, double height);
  // Sphere: a polyhedron of 16 x 32 faces that deviates by less than 0.5 % of the radius.
  static Occluder sphere(const Eigen::Vector3d& p_WS, double diameter);
  // A mesh, triangle by triangle; `triangles` index the vertices. Of hundreds of triangles each costs about a microsecond per
  // evaluation. Outside of the grid only; what lies inside it is to be marked as environment (voxelize.h).
  // Throws Error(bad_input) for an index out of range.
  static std::vector<Occluder> mesh(const std::vector<Eigen::Vector3d>& vertices_W, const std::vector<Eigen::Vector3i>& triangles);
};

}  // namespace periplus::voxel
