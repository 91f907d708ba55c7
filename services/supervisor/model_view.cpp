#include "services/supervisor/model_view.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "common/mesh/triangle_mesh.h"

namespace periplus::supervisor {

namespace {

// Rows: right, up, towards the viewer.
Eigen::Matrix3d view_rotation(double azimuth, double elevation) {
  const Eigen::Vector3d to_viewer(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  const Eigen::Vector3d right(-std::sin(azimuth), std::cos(azimuth), 0);
  Eigen::Matrix3d R;
  R << right.transpose(), to_viewer.cross(right).transpose(), to_viewer.transpose();
  return R;
}

ImageU8 render(const mesh::TriangleMesh& m, const Eigen::Matrix3d& R, int size, const mesh::Bounds& b, double scale) {
  const Eigen::Vector3d middle = (b.lower + b.upper) / 2;
  ImageU8 image(size, size, 3, 250);
  std::vector<double> nearest(static_cast<std::size_t>(size) * size, -1e30);
  const Eigen::Vector3d light = Eigen::Vector3d(-0.3, 0.5, 0.8).normalized();
  for (const Eigen::Vector3i& t : m.triangles) {
    Eigen::Vector3d p[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = scale * (R * (m.vertices[static_cast<std::size_t>(t[k])] - middle));
      p[k].x() += size / 2.0;
      p[k].y() = size / 2.0 - p[k].y();
    }
    const double area = (p[1].x() - p[0].x()) * (p[2].y() - p[0].y()) - (p[2].x() - p[0].x()) * (p[1].y() - p[0].y());
    if (std::abs(area) < 1e-12) continue;
    Eigen::Vector3d n = (R * (m.vertices[static_cast<std::size_t>(t[1])] - m.vertices[static_cast<std::size_t>(t[0])])
                                 .cross(m.vertices[static_cast<std::size_t>(t[2])] - m.vertices[static_cast<std::size_t>(t[0])]))
                            .normalized();
    if (n.z() < 0) n = -n;
    const double shade = 0.45 + 0.55 * std::max(0.0, n.dot(light));
    const int x0 = std::max(0, static_cast<int>(std::floor(std::min({p[0].x(), p[1].x(), p[2].x()}))));
    const int x1 = std::min(size - 1, static_cast<int>(std::ceil(std::max({p[0].x(), p[1].x(), p[2].x()}))));
    const int y0 = std::max(0, static_cast<int>(std::floor(std::min({p[0].y(), p[1].y(), p[2].y()}))));
    const int y1 = std::min(size - 1, static_cast<int>(std::ceil(std::max({p[0].y(), p[1].y(), p[2].y()}))));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const double w1 = ((x - p[0].x()) * (p[2].y() - p[0].y()) - (p[2].x() - p[0].x()) * (y - p[0].y())) / area;
        const double w2 = ((p[1].x() - p[0].x()) * (y - p[0].y()) - (x - p[0].x()) * (p[1].y() - p[0].y())) / area;
        const double w0 = 1 - w1 - w2;
        if (w0 < -1e-9 || w1 < -1e-9 || w2 < -1e-9) continue;
        const double z = w0 * p[0].z() + w1 * p[1].z() + w2 * p[2].z();
        double& depth = nearest[static_cast<std::size_t>(y) * size + x];
        if (z <= depth) continue;
        depth = z;
        Eigen::Vector3d colour(0.72, 0.72, 0.75);
        if (!m.colours.empty())
          colour = w0 * m.colours[static_cast<std::size_t>(t[0])] + w1 * m.colours[static_cast<std::size_t>(t[1])] + w2 * m.colours[static_cast<std::size_t>(t[2])];
        for (int k = 0; k < 3; ++k) image.at(x, y, k) = static_cast<std::uint8_t>(std::clamp(255 * shade * colour[k], 0.0, 255.0));
      }
  }
  return image;
}

}  // namespace

ImageU8 draw_model(const mesh::TriangleMesh& mesh, double azimuth, double elevation, int size_px, const mesh::Bounds& frame) {
  const double across = frame.size().head<2>().norm();
  const double high = frame.size().z() * std::cos(elevation) + across * std::sin(elevation);
  return render(mesh, view_rotation(azimuth, elevation), size_px, frame, 0.94 * size_px / std::max(across, high));
}

std::vector<ModelView> model_views(const std::string& ply_path, int size_px) {
  std::vector<ModelView> views;
  if (!std::filesystem::exists(ply_path)) return views;
  const mesh::TriangleMesh m = mesh::load(ply_path);
  const mesh::Bounds b = mesh::bounds(m);
  const double scale = 0.92 * size_px / b.size().norm();
  constexpr double quarter = std::numbers::pi / 2, up = 20 * std::numbers::pi / 180;
  const char* names[] = {"front", "left", "back", "right"};
  for (int i = 0; i < 4; ++i) views.push_back({names[i], render(m, view_rotation(-quarter + i * quarter, up), size_px, b, scale)});
  views.push_back({"above", render(m, view_rotation(-quarter, quarter), size_px, b, scale)});
  return views;
}

}  // namespace periplus::supervisor
