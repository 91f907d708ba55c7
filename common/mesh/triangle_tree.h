// Bounding-volume tree over a mesh's triangles: closest points, of segments too, and first hits of rays.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>

#include "common/mesh/triangle_mesh.h"

namespace periplus::mesh {

// Immutable; may be shared between threads. Keeps a copy of the corners.
class TriangleTree {
 public:
  // Throws Error(bad_input) for a mesh without triangles.
  explicit TriangleTree(const TriangleMesh& mesh);
  ~TriangleTree();
  TriangleTree(TriangleTree&&) noexcept;

  struct Closest {
    double distance = 0;  // [m], never negative
    Eigen::Vector3d point;
    int triangle = -1;
  };
  Closest closest(const Eigen::Vector3d& p) const;

  struct ClosestToSegment {
    double distance = 0;           // [m], 0 where the segment meets a triangle
    double t = 0;                  // nearest point of the segment: a + t (b - a)
    Eigen::Vector3d point;         // of the mesh
    int triangle = -1;
  };
  // Of the segment a-b, which may be a point.
  ClosestToSegment closest_to_segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  struct Hit {
    double t = 0;         // hit point = origin + t * direction
    int triangle = -1;
  };
  // From either side of a triangle; t from 0 to `t_max`.
  std::optional<Hit> ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                         double t_max = std::numeric_limits<double>::infinity()) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::mesh
