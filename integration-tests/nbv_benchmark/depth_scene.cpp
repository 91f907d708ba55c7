#include "integration-tests/nbv_benchmark/depth_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/error.h"

namespace periplus::nbv_benchmark {
namespace {

constexpr double kPlane = 1e-3;  // triangles that reach before this plane are tried at every pixel [m]

}  // namespace

void DepthScene::add(const mesh::TriangleMesh& mesh, const Pose& X_WM) {
  const int first = static_cast<int>(vertices_.size());
  for (const Eigen::Vector3d& p : mesh.vertices) vertices_.push_back(X_WM * p);
  for (const Eigen::Vector3i& t : mesh.triangles) triangles_.push_back(t.array() + first);
}

ImageF DepthScene::render(const Pose& X_WC, const Pinhole& camera, float background) const {
  require(is_finite(X_WC), ErrorCode::not_finite, "a camera's pose must be finite");
  camera.check();
  const int width = camera.width, height = camera.height;
  const Pose X_CW = X_WC.inverse();
  std::vector<Eigen::Vector3d> points(vertices_.size());
  std::vector<Eigen::Vector2d> pixels(vertices_.size());
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    points[i] = X_CW * vertices_[i];
    if (points[i].z() > kPlane) pixels[i] = camera.project(points[i]);
  }
  constexpr double nothing = std::numeric_limits<double>::infinity();
  std::vector<double> nearest(static_cast<std::size_t>(width) * height, nothing);
  for (const Eigen::Vector3i& t : triangles_) {
    const Eigen::Vector3d &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
    if (a.z() <= 0 && b.z() <= 0 && c.z() <= 0) continue;
    int x0 = 0, x1 = width - 1, y0 = 0, y1 = height - 1;
    if (a.z() > kPlane && b.z() > kPlane && c.z() > kPlane) {
      const Eigen::Vector2d low = pixels[t[0]].cwiseMin(pixels[t[1]]).cwiseMin(pixels[t[2]]);
      const Eigen::Vector2d high = pixels[t[0]].cwiseMax(pixels[t[1]]).cwiseMax(pixels[t[2]]);
      if (high.x() < 0 || high.y() < 0 || low.x() > x1 || low.y() > y1) continue;
      // A little wider than the projection, whose rounding must not decide about an edge.
      constexpr double slack = 1e-6;
      x0 = static_cast<int>(std::ceil(std::max(low.x() - slack, 0.0)));
      y0 = static_cast<int>(std::ceil(std::max(low.y() - slack, 0.0)));
      x1 = static_cast<int>(std::floor(std::min(high.x() + slack, double(x1))));
      y1 = static_cast<int>(std::floor(std::min(high.y() + slack, double(y1))));
    }
    if (x0 > x1 || y0 > y1) continue;
    // The ray r lies within the triangle if it is on one side of the three planes through the camera and an edge; its depth there
    // is det / sum (r = (x, y, 1)). Olano, Greer: Triangle scan conversion using 2D homogeneous coordinates, 1997.
    const Eigen::Vector3d ea = b.cross(c), eb = c.cross(a), ec = a.cross(b);
    const double det = a.dot(ea);
    if (det == 0) continue;
    for (int v = y0; v <= y1; ++v) {
      const double y = (v - camera.cy) / camera.fy;
      const double ra = ea.y() * y + ea.z(), rb = eb.y() * y + eb.z(), rc = ec.y() * y + ec.z();
      double* row = nearest.data() + static_cast<std::size_t>(v) * width;
      for (int u = x0; u <= x1; ++u) {
        const double x = (u - camera.cx) / camera.fx;
        const double wa = ea.x() * x + ra, wb = eb.x() * x + rb, wc = ec.x() * x + rc;
        if (!((wa >= 0 && wb >= 0 && wc >= 0) || (wa <= 0 && wb <= 0 && wc <= 0))) continue;
        const double sum = wa + wb + wc;
        if (sum == 0) continue;
        const double z = det / sum;
        if (z > 0 && z < row[u]) row[u] = z;
      }
    }
  }
  ImageF depth(width, height);
  for (std::size_t i = 0; i < nearest.size(); ++i) depth.data[i] = nearest[i] == nothing ? background : static_cast<float>(nearest[i]);
  return depth;
}

}  // namespace periplus::nbv_benchmark
