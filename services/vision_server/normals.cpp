#include "services/vision_server/normals.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace periplus::vision {

std::optional<Eigen::Vector3d> normal_at(const ImageF& depth, const Pinhole& camera, int u, int v, int half_window,
                                         double reach) {
  if (u < 0 || v < 0 || u >= depth.width || v >= depth.height || depth.at(u, v) <= 0) return std::nullopt;
  const double z0 = depth.at(u, v);
  const Eigen::Vector3d p0 = camera.back_project(u, v, z0);
  int count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (int y = std::max(0, v - half_window); y <= std::min(depth.height - 1, v + half_window); ++y)
    for (int x = std::max(0, u - half_window); x <= std::min(depth.width - 1, u + half_window); ++x) {
      const double z = depth.at(x, y);
      if (z <= 0 || std::abs(z - z0) > reach) continue;
      const Eigen::Vector3d p = camera.back_project(x, y, z) - p0;
      sum += p;
      squares += p * p.transpose();
      ++count;
    }
  const int side = 2 * half_window + 1;
  if (count < std::max(6, side * side / 3)) return std::nullopt;
  const Eigen::Vector3d mean = sum / count;
  const Eigen::Matrix3d covariance = squares / count - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
  // A plane is thin: its least extent is well below the next.
  if (!(axes.eigenvalues()[0] < 0.2 * axes.eigenvalues()[1])) return std::nullopt;
  Eigen::Vector3d n = axes.eigenvectors().col(0).normalized();
  if (n.dot(p0) > 0) n = -n;
  return n;
}

}  // namespace periplus::vision
