#include "services/nbv_planner/tool/voxel_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/scene/mesh_solid.h"

namespace periplus::nbv {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr float kNothing = -std::numeric_limits<float>::infinity();
constexpr double kNearest = 0.05;  // [m]
const Vector3d kUnknown(0.38, 0.76, 0.36), kKnown(0.66, 0.68, 0.72), kEnvironment(0.55, 0.40, 0.27), kSolid(0.85, 0.79, 0.68);

struct Layer {
  Layer(int w, int h) : rgb(w, h, 3), nearness(w, h, 1, kNothing) {}
  ImageF rgb;
  ImageF nearness;
};

// The light comes over the viewer's right shoulder, so that no side is dark from anywhere.
Vector3d light_of(const Projection& project, const Vector3d& at) {
  const Vector3d to_viewer = project.to_viewer(at).normalized();
  Vector3d right = Vector3d::UnitZ().cross(to_viewer);
  right = right.norm() > 1e-3 ? Vector3d(right.normalized()) : Vector3d::UnitX();
  return (0.55 * to_viewer + 0.45 * right + 0.75 * Vector3d::UnitZ()).normalized();
}

double shade(const Vector3d& normal, const Vector3d& light) { return 0.58 + 0.42 * std::max(-0.3, normal.dot(light)); }

// A flat quadrilateral, corners in order. `edge`: width of the darker rim [px], 0: none.
void fill(Layer& to, const Projection& project, const std::array<Vector3d, 4>& corners, const Vector3d& colour, double edge) {
  std::array<Vector3d, 4> p;
  for (int k = 0; k < 4; ++k) {
    if (!project.before(corners[k])) return;
    p[k] = project(corners[k]);
  }
  const int w = to.nearness.width, h = to.nearness.height;
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
    const Vector3d &pa = p[a], &pb = p[b], &pc = p[c];
    const double area = (pb.x() - pa.x()) * (pc.y() - pa.y()) - (pc.x() - pa.x()) * (pb.y() - pa.y());
    if (std::abs(area) < 1e-12) continue;
    const int u0 = std::max(0, static_cast<int>(std::ceil(std::clamp(std::min({pa.x(), pb.x(), pc.x()}), -1e6, 1e6) - 1e-9)));
    const int u1 = std::min(w - 1, static_cast<int>(std::floor(std::clamp(std::max({pa.x(), pb.x(), pc.x()}), -1e6, 1e6))));
    const int v0 = std::max(0, static_cast<int>(std::ceil(std::clamp(std::min({pa.y(), pb.y(), pc.y()}), -1e6, 1e6) - 1e-9)));
    const int v1 = std::min(h - 1, static_cast<int>(std::floor(std::clamp(std::max({pa.y(), pb.y(), pc.y()}), -1e6, 1e6))));
    for (int v = v0; v <= v1; ++v) {
      for (int u = u0; u <= u1; ++u) {
        const double wb = ((u - pa.x()) * (pc.y() - pa.y()) - (pc.x() - pa.x()) * (v - pa.y())) / area;
        const double wc = ((pb.x() - pa.x()) * (v - pa.y()) - (u - pa.x()) * (pb.y() - pa.y())) / area;
        const double wa = 1 - wb - wc;
        if (wa < -1e-9 || wb < -1e-9 || wc < -1e-9) continue;
        const auto near = static_cast<float>(wa * pa.z() + wb * pb.z() + wc * pc.z());
        if (near <= to.nearness.at(u, v)) continue;
        to.nearness.at(u, v) = near;
        Vector3d shown = colour;
        if (edge > 0) {
          for (int k = 0; k < 4; ++k) {  // distance to the four sides
            const Vector2d side = (p[(k + 1) % 4] - p[k]).head<2>(), from = Vector2d(u, v) - p[k].head<2>();
            if (std::abs(side.x() * from.y() - side.y() * from.x()) < edge * side.norm()) shown = 0.72 * colour;
          }
        }
        for (int c3 = 0; c3 < 3; ++c3) to.rgb.at(u, v, c3) = static_cast<float>(shown[c3]);
      }
    }
  }
}

void draw_grid(Layer& to, const voxel::OccupancyGrid& grid, const Projection& project, const Vector3d& light) {
  const voxel::GridGeometry& g = grid.geometry();
  const Vector3d middle = g.X_WG * (g.size.cast<double>() * g.voxel_size / 2);
  const double voxel_px = (project.point(middle + g.X_WG.linear().col(0) * g.voxel_size) - project.point(middle)).norm() +
                          (project.point(middle + g.X_WG.linear().col(2) * g.voxel_size) - project.point(middle)).norm();
  const double edge = voxel_px > 14 ? voxel_px / 28 : 0;
  for (int x = 0; x < g.size.x(); ++x) {
    for (int y = 0; y < g.size.y(); ++y) {
      for (int z = 0; z < g.size.z(); ++z) {
        const Vector3i v(x, y, z);
        const voxel::VoxelState state = grid.state(v);
        if (state == voxel::VoxelState::empty) continue;
        const Vector3d& colour = state == voxel::VoxelState::unknown ? kUnknown : state == voxel::VoxelState::known ? kKnown : kEnvironment;
        for (int face = 0; face < 6; ++face) {
          const int axis = face / 2, side = face % 2;
          Vector3i beside = v;
          beside[axis] += side ? 1 : -1;
          if (grid.state(beside) != voxel::VoxelState::empty) continue;
          const Vector3d normal = (side ? 1 : -1) * g.X_WG.linear().col(axis);
          std::array<Vector3d, 4> corners;
          for (int k = 0; k < 4; ++k) {
            Vector3d c = v.cast<double>();
            c[axis] += side;
            c[(axis + 1) % 3] += k == 1 || k == 2;
            c[(axis + 2) % 3] += k >= 2;
            corners[k] = g.X_WG * (c * g.voxel_size);
          }
          if (normal.dot(project.to_viewer(corners[0])) <= 0) continue;
          fill(to, project, corners, shade(normal, light) * colour, edge);
        }
      }
    }
  }
}

// A convex solid of quadrilaterals: rings of points from bottom to top, closed by its ends.
void draw_rings(Layer& to, const Projection& project, const std::vector<std::vector<Vector3d>>& rings, const Vector3d& middle,
                const Vector3d& light) {
  const auto face = [&](const std::array<Vector3d, 4>& q) {
    Vector3d normal = (q[2] - q[0]).cross(q[3] - q[1]);
    if (normal.squaredNorm() < 1e-18) return;
    normal.normalize();
    const Vector3d at = (q[0] + q[1] + q[2] + q[3]) / 4;
    if (normal.dot(at - middle) < 0) normal = -normal;
    if (normal.dot(project.to_viewer(at)) > 0) fill(to, project, q, shade(normal, light) * kSolid, 0);
  };
  const std::size_t n = rings.front().size();
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    for (std::size_t i = 0; i < n; ++i) face({rings[r][i], rings[r][(i + 1) % n], rings[r + 1][(i + 1) % n], rings[r + 1][i]});
  }
  for (const auto* end : {&rings.front(), &rings.back()}) {
    Vector3d center = Vector3d::Zero();
    for (const Vector3d& p : *end) center += p / static_cast<double>(n);
    for (std::size_t i = 0; i < n; i += 2) face({center, (*end)[i], (*end)[(i + 1) % n], (*end)[(i + 2) % n]});
  }
}

void draw_mesh(Layer& to, const scene::Solid& s, const Projection& project, const Vector3d& light) {
  for (const Eigen::Vector3i& t : s.mesh->mesh().triangles) {
    std::array<Vector3d, 4> q;
    for (std::size_t k = 0; k < 4; ++k) q[k] = s.X_WS * s.mesh->mesh().vertices[static_cast<std::size_t>(t[std::min(static_cast<int>(k), 2)])];
    Vector3d normal = (q[1] - q[0]).cross(q[2] - q[0]);
    if (normal.squaredNorm() < 1e-24) continue;
    normal.normalize();
    if (normal.dot(project.to_viewer(q[0])) <= 0) {
      if (s.mesh->closed()) continue;
      normal = -normal;  // a skin is seen from both sides
    }
    fill(to, project, q, shade(normal, light) * kSolid, 0);
  }
}

void draw_solid(Layer& to, const scene::Solid& s, const Projection& project, const Vector3d& light) {
  if (s.shape == scene::Shape::mesh) return draw_mesh(to, s, project, light);
  std::vector<std::vector<Vector3d>> rings;
  const Vector3d half = s.size / 2;
  const auto ring = [&](double rx, double ry, double z, int n, double turn) {
    std::vector<Vector3d> points;
    for (int i = 0; i < n; ++i) {
      const double a = 2 * std::numbers::pi * i / n + turn;
      points.push_back(s.X_WS * Vector3d(rx * std::cos(a), ry * std::sin(a), z));
    }
    rings.push_back(points);
  };
  if (s.shape == scene::Shape::box) {
    const double r = std::numbers::sqrt2;
    for (double z : {-half.z(), half.z()}) ring(r * half.x(), r * half.y(), z, 4, std::numbers::pi / 4);
  } else if (s.shape == scene::Shape::cylinder) {
    for (double z : {-half.z(), half.z()}) ring(half.x(), half.x(), z, 48, 0);
  } else {
    for (int k = 0; k <= 24; ++k) {
      const double a = std::numbers::pi * (k / 24.0 - 0.5);
      ring(half.x() * std::cos(a), half.x() * std::cos(a), half.x() * std::sin(a), 48, 0);
    }
  }
  draw_rings(to, project, rings, s.X_WS.translation(), light);
}

}  // namespace

Projection Projection::parallel(double azimuth, double elevation, const Vector3d& middle, double px_per_m, int width, int height) {
  Projection p;
  p.width_ = width;
  p.height_ = height;
  p.scale_ = px_per_m;
  p.shift_ = {width / 2.0, height / 2.0};
  const Vector3d away(-std::cos(elevation) * std::cos(azimuth), -std::cos(elevation) * std::sin(azimuth), -std::sin(elevation));
  const Vector3d right(-std::sin(azimuth), std::cos(azimuth), 0);
  Eigen::Matrix3d R_WV;
  R_WV << right, away.cross(right), away;
  p.X_CW_ = make_pose(middle, R_WV).inverse();
  return p;
}

Projection Projection::above(const Vector3d& middle, double px_per_m, int width, int height) {
  return parallel(-std::numbers::pi / 2, std::numbers::pi / 2, middle, px_per_m, width, height);
}

Projection Projection::camera(const Pose& X_WC, const Pinhole& camera) {
  Projection p;
  p.is_camera_ = true;
  p.width_ = camera.width;
  p.height_ = camera.height;
  p.X_CW_ = X_WC.inverse();
  p.pinhole_ = camera;
  return p;
}

Vector3d Projection::operator()(const Vector3d& p_W) const {
  const Vector3d p = X_CW_ * p_W;
  if (is_camera_) {
    const Vector2d uv = pinhole_.project(p);
    return {uv.x(), uv.y(), 1 / p.z()};
  }
  return {scale_ * p.x() + shift_.x(), scale_ * p.y() + shift_.y(), -p.z()};
}

bool Projection::before(const Vector3d& p_W) const { return !is_camera_ || (X_CW_ * p_W).z() > kNearest; }

Vector3d Projection::to_viewer(const Vector3d& p_W) const {
  const Pose X_WC = X_CW_.inverse();
  return is_camera_ ? Vector3d(X_WC.translation() - p_W) : Vector3d(-X_WC.linear().col(2));
}

Projection Projection::finer(int factor) const {
  Projection p = *this;
  p.width_ *= factor;
  p.height_ *= factor;
  p.scale_ *= factor;
  p.shift_ *= factor;
  p.pinhole_.width *= factor;
  p.pinhole_.height *= factor;
  p.pinhole_.fx *= factor;
  p.pinhole_.fy *= factor;
  p.pinhole_.cx = (p.pinhole_.cx + 0.5) * factor - 0.5;
  p.pinhole_.cy = (p.pinhole_.cy + 0.5) * factor - 0.5;
  return p;
}

VoxelView draw_voxels(const voxel::OccupancyGrid& grid, const scene::Scene& scene, const Projection& projection) {
  const int w = projection.width(), h = projection.height();
  Layer object(w, h), solids(w, h);
  const Vector3d light = light_of(projection, grid.geometry().X_WG * (grid.geometry().size.cast<double>() * grid.geometry().voxel_size / 2));
  draw_grid(object, grid, projection, light);
  for (const scene::Solid& s : scene.solids) draw_solid(solids, s, projection, light);
  VoxelView view;
  view.rgba = ImageU8(w, h, 4);
  view.nearness = object.nearness;
  for (int v = 0; v < h; ++v) {
    for (int u = 0; u < w; ++u) {
      const float o = object.nearness.at(u, v), s = solids.nearness.at(u, v);
      const bool in_front = s > o && o > kNothing;
      const double glass = projection.is_camera() ? 1 : in_front ? 0.45 : s > o ? 0.8 : 0;
      if (s > o && o == kNothing) view.nearness.at(u, v) = s;
      for (int c = 0; c < 3; ++c) {
        const double base = o > kNothing ? object.rgb.at(u, v, c) : s > o ? solids.rgb.at(u, v, c) : 1;
        const double shown = in_front ? (1 - glass) * base + glass * solids.rgb.at(u, v, c) : base;
        view.rgba.at(u, v, c) = static_cast<std::uint8_t>(std::lround(255 * std::clamp(shown, 0.0, 1.0)));
      }
      view.rgba.at(u, v, 3) = static_cast<std::uint8_t>(o > kNothing ? 255 : s > kNothing ? (projection.is_camera() ? 255 : 205) : 0);
    }
  }
  return view;
}

}  // namespace periplus::nbv
