// True depth maps of triangles, without a graphics library: each pixel's ray against the triangles that its projection may meet.
// Exact up to rounding, watertight along shared edges, the same bytes on every machine and from every thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "common/mesh/triangle_mesh.h"

namespace periplus::nbv_benchmark {

class DepthScene {
 public:
  // Triangles are seen from both sides.
  void add(const mesh::TriangleMesh& mesh, const Pose& X_WM);

  // Depth along the optical axis [m] of what the ray through each pixel's centre meets first; `background` where it meets
  // nothing. Throws Error(not_finite | bad_input) for an impossible pose or camera.
  ImageF render(const Pose& X_WC, const Pinhole& camera, float background) const;

 private:
  std::vector<Eigen::Vector3d> vertices_;   // world
  std::vector<Eigen::Vector3i> triangles_;
};

}  // namespace periplus::nbv_benchmark
