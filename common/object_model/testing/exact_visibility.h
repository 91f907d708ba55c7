// Which voxels cameras truly see, by rays that nothing but the object stops: what labels are held against.
#pragma once

#include <algorithm>
#include <vector>

#include "common/mesh/triangle_tree.h"
#include "common/object_model/perception.h"
#include "common/voxel/ray_traversal.h"

namespace periplus::object_model::testing {

// Marks (by voxel_index()) the voxels that the rays through the pixels' centres pass up to the true depth.
inline void mark_reached(const DepthMap& truth, const voxel::GridGeometry& g, std::vector<std::uint8_t>& reached) {
  const Pose X_GC = g.X_WG.inverse() * truth.X_WC;
  for (int y = 0; y < truth.camera.height; ++y)
    for (int x = 0; x < truth.camera.width; ++x) {
      const Eigen::Vector3d ray = X_GC.linear() * truth.camera.back_project(x, y, truth.depth.at(x, y));
      const double range = ray.norm();
      if (range == 0) continue;
      voxel::traverse_ray(g, X_GC.translation(), ray / range, range + 1e-6, [&](const Eigen::Vector3i& v, double, double) {
        reached[voxel::voxel_index(g, v)] = 1;
        return true;
      });
    }
}

// True if the camera sees one of 6^3 points within a voxel, its corners among them: between the pixels' centres too.
inline bool sees_within(const voxel::GridGeometry& g, const Eigen::Vector3i& v, const mesh::TriangleTree& object_W, const Pinhole& camera, const Pose& X_WC) {
  constexpr int kPoints = 6;
  const Pose X_CW = X_WC.inverse();
  for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
    const Eigen::Vector3d at = Eigen::Vector3d(i % kPoints, i / kPoints % kPoints, i / kPoints / kPoints) / (kPoints - 1);
    const Eigen::Vector3d p_W = g.X_WG * ((v.cast<double>() + at) * g.voxel_size), p_C = X_CW * p_W;
    if (!(p_C.z() > 0)) continue;
    const Eigen::Vector2d q = camera.project(p_C);
    if ((q.array() < -0.5).any() || q.x() >= camera.width - 0.5 || q.y() >= camera.height - 0.5) continue;
    if (!object_W.ray(X_WC.translation(), p_W - X_WC.translation(), 1 - 1e-9)) return true;
  }
  return false;
}

// Counts, for each voxel, the pixels that show the surface in it at no more than 60 degrees from its normal; for pixels with a `measured` depth.
inline std::vector<int> plain_pixels(const DepthMap& truth, const ImageF& measured, const voxel::GridGeometry& g) {
  constexpr double kLeastCosine = 0.5;
  std::vector<int> pixels(static_cast<std::size_t>(g.size.prod()), 0);
  const auto point = [&](int x, int y) { return truth.camera.back_project(x, y, truth.depth.at(x, y)); };
  for (int y = 1; y + 1 < truth.camera.height; ++y)
    for (int x = 1; x + 1 < truth.camera.width; ++x) {
      const float* z = &truth.depth.at(x, y);
      if (!(measured.at(x, y) > 0) || !(std::min({z[0], z[-1], z[1], z[-truth.camera.width], z[truth.camera.width]}) > 0)) continue;
      const Eigen::Vector3d p = point(x, y), normal = (point(x, y + 1) - point(x, y - 1)).cross(point(x + 1, y) - point(x - 1, y));
      if (!(std::abs(normal.dot(p)) >= kLeastCosine * normal.norm() * p.norm())) continue;
      const Eigen::Vector3i v = g.voxel_of(truth.X_WC * p);
      if (g.contains(v)) ++pixels[voxel::voxel_index(g, v)];
    }
  return pixels;
}

}  // namespace periplus::object_model::testing
