// Objects made of random solids, and what a camera truly sees of them: what the properties of carving are held against.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "common/core/random.h"
#include "common/mesh/part_builder.h"
#include "common/object_model/perception.h"
#include "common/scene/mesh_solid.h"
#include "common/voxel/voxelize.h"

namespace periplus::object_model::testing {

inline Eigen::Matrix3d random_rotation(Random& random) {
  return rotation_from_yaw_pitch_roll(random.uniform(-3.1, 3.1), random.uniform(-1.5, 1.5), random.uniform(-3.1, 3.1));
}
inline Eigen::Vector3d random_in_cube(Random& random, double half) { return {random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half)}; }

// A closed part of at most some 0.2 m: ball, bumpy ellipsoid, box, thin slanted plate, thin rod, ring.
inline mesh::TriangleMesh random_part(Random& random) {
  constexpr auto kMaterial = mesh::Material::stone;
  mesh::PartBuilder part(1);
  switch (random.below(6)) {
    case 0: part.lump({0, 0, 0}, Eigen::Vector3d::Constant(random.uniform(0.02, 0.09)), 0, 1, kMaterial); break;
    case 1: part.lump({0, 0, 0}, {random.uniform(0.02, 0.1), random.uniform(0.02, 0.1), random.uniform(0.02, 0.1)}, 0.2, random.next(), kMaterial); break;
    case 2: part.box(Pose::Identity(), {random.uniform(0.03, 0.15), random.uniform(0.03, 0.15), random.uniform(0.03, 0.15)}, 0.05, kMaterial); break;
    case 3: part.box(Pose::Identity(), {random.uniform(0.08, 0.2), random.uniform(0.08, 0.2), random.uniform(0.001, 0.006)}, 0.05, kMaterial); break;
    case 4: {
      const double radius = random.uniform(0.001, 0.006), half = random.uniform(0.04, 0.1);
      part.tube({0, 0, -half}, {0, 0, half}, radius, radius, 8, kMaterial);
      break;
    }
    default: {
      const double around = random.uniform(0.04, 0.08), radius = random.uniform(0.004, 0.025);
      std::vector<Eigen::Vector3d> line;
      for (int i = 0; i < 24; ++i) line.emplace_back(around * std::cos(i * std::numbers::pi / 12), around * std::sin(i * std::numbers::pi / 12), 0);
      part.tube(line, std::vector<double>(line.size(), radius), 10, kMaterial, true);
    }
  }
  return part.mesh();
}

// Some random parts, which may reach into one another.
class RandomSolids {
 public:
  RandomSolids(Random& random, const Eigen::Vector3d& middle_W) {
    for (auto n = 3 + random.below(4); n > 0; --n) {
      parts_.push_back({scene::MeshSolid(random_part(random)), make_pose(middle_W + random_in_cube(random, 0.12), random_rotation(random))});
      mesh::TriangleMesh m = parts_.back().solid.mesh();
      mesh::transform(m, parts_.back().X_WS);
      const Eigen::Vector3i first = Eigen::Vector3i::Constant(static_cast<int>(mesh_W_.vertices.size()));
      mesh_W_.vertices.insert(mesh_W_.vertices.end(), m.vertices.begin(), m.vertices.end());
      for (const Eigen::Vector3i& t : m.triangles) mesh_W_.triangles.push_back(t + first);
    }
  }

  const mesh::TriangleMesh& mesh_W() const { return mesh_W_; }
  bool all_closed() const {
    return std::all_of(parts_.begin(), parts_.end(), [](const Part& p) { return p.solid.closed(); });
  }
  bool contains(const Eigen::Vector3d& p_W) const {
    Eigen::Vector3d gradient;
    return std::any_of(parts_.begin(), parts_.end(), [&](const Part& p) {
      const Eigen::Vector3d p_S = p.X_WS.inverse() * p_W;
      return (p_S.cwiseAbs().array() <= p.solid.size().array() / 2).all() && p.solid.distance(p_S, gradient) < 0;
    });
  }

 private:
  struct Part {
    scene::MeshSolid solid;
    Pose X_WS;
  };
  std::vector<Part> parts_;
  mesh::TriangleMesh mesh_W_;
};

// Plane of the voxels that the surface passes through, exactly: closed cubes and triangles.
inline std::vector<std::uint64_t> surface_voxels(const mesh::TriangleMesh& mesh_W, const voxel::GridGeometry& g) {
  voxel::OccupancyGrid grid(g);
  voxel::mark_environment(mesh_W.vertices, mesh_W.triangles, grid);
  return grid.environment();
}

// The solids fill at most this share of a voxel: of 16^3 cells, all of those that the surface passes
// through count as full.
inline double filled_share_at_most(const RandomSolids& solids, const voxel::GridGeometry& g, const Eigen::Vector3i& v) {
  voxel::GridGeometry cells;
  cells.size = Eigen::Vector3i::Constant(16);
  cells.voxel_size = g.voxel_size / 16;
  cells.X_WG = g.X_WG;
  cells.X_WG.translation() = g.X_WG * (v.cast<double>() * g.voxel_size);
  voxel::OccupancyGrid grid(cells);
  voxel::mark_environment(solids.mesh_W().vertices, solids.mesh_W().triangles, grid);
  int filled = 0;
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 16; ++y)
      for (int z = 0; z < 16; ++z) {
        const Eigen::Vector3i c(x, y, z);
        filled += grid.state(c) == voxel::VoxelState::environment || solids.contains(cells.center_world(c));
      }
  return filled / (16.0 * 16 * 16);
}

// A corner of a triangle's part in the image: pixels, and the inverse of the depth, which is linear over a plane's image.
struct ImageCorner {
  double u, v, inverse;
};

// The part of a convex polygon where sign * (u or v) <= sign * bound (Sutherland and Hodgman 1974).
inline void clip(std::vector<ImageCorner>& polygon, double ImageCorner::*axis, double sign, double bound, std::vector<ImageCorner>& scratch) {
  scratch.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const ImageCorner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a.*axis - bound), db = sign * (b.*axis - bound);
    if (da <= 0) scratch.push_back(a);
    if ((da <= 0) != (db <= 0)) {
      const double t = da / (da - db);
      scratch.push_back({a.u + t * (b.u - a.u), a.v + t * (b.v - a.v), a.inverse + t * (b.inverse - a.inverse)});
    }
  }
  polygon.swap(scratch);
}

// Exact depth of a mesh before a wall at `wall` [m] along the optical axis. `depth_minimum`: the least depth over a pixel's square, from
// below (a plane's depth is least at a corner of its part in the square); `depth`: at its centre. All of the mesh must be in front of the camera.
inline DepthMap exact_depth(const mesh::TriangleMesh& mesh_W, const Pinhole& camera, const Pose& X_WC, double wall) {
  constexpr double kWider = 1e-6;  // than the pixel, for rounding [px]
  std::vector<double> nearest(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height), 1 / wall), center = nearest;
  std::vector<ImageCorner> corners, polygon, scratch;
  for (const Eigen::Vector3d& p_W : mesh_W.vertices) {
    const Eigen::Vector3d p = X_WC.inverse() * p_W;
    require(p.z() > 0.01, ErrorCode::bad_input, "a mesh reaches behind the camera");
    const Eigen::Vector2d q = camera.project(p);
    corners.push_back({q.x(), q.y(), 1 / p.z()});
  }
  for (const Eigen::Vector3i& t : mesh_W.triangles) {
    const std::array<ImageCorner, 3> c{corners[static_cast<std::size_t>(t[0])], corners[static_cast<std::size_t>(t[1])], corners[static_cast<std::size_t>(t[2])]};
    const auto [left, right] = std::minmax({c[0].u, c[1].u, c[2].u});
    const auto [top, bottom] = std::minmax({c[0].v, c[1].v, c[2].v});
    const auto first = [](double least) { return static_cast<int>(std::max(0.0, std::floor(least + 0.5 - kWider))); };
    const auto last = [](double most, int size) { return static_cast<int>(std::min(size - 1.0, std::floor(most + 0.5 + kWider))); };
    const double du1 = c[1].u - c[0].u, dv1 = c[1].v - c[0].v, du2 = c[2].u - c[0].u, dv2 = c[2].v - c[0].v, area = du1 * dv2 - du2 * dv1;
    for (int y = first(top); y <= last(bottom, camera.height); ++y)
      for (int x = first(left); x <= last(right, camera.width); ++x) {
        polygon.assign(c.begin(), c.end());
        const double half = 0.5 + kWider;
        clip(polygon, &ImageCorner::u, 1, x + half, scratch);
        clip(polygon, &ImageCorner::u, -1, x - half, scratch);
        clip(polygon, &ImageCorner::v, 1, y + half, scratch);
        clip(polygon, &ImageCorner::v, -1, y - half, scratch);
        const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(x);
        for (const ImageCorner& p : polygon) nearest[at] = std::max(nearest[at], p.inverse);
        const double a = ((x - c[0].u) * dv2 - (y - c[0].v) * du2) / area, b = ((y - c[0].v) * du1 - (x - c[0].u) * dv1) / area;
        if (a >= 0 && b >= 0 && a + b <= 1) center[at] = std::max(center[at], c[0].inverse + a * (c[1].inverse - c[0].inverse) + b * (c[2].inverse - c[0].inverse));
      }
  }
  DepthMap map;
  map.camera = camera;
  map.X_WC = X_WC;
  map.depth = map.depth_minimum = map.depth_sigma = ImageF(camera.width, camera.height);
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    map.depth.data[i] = static_cast<float>(1 / center[i]);
    map.depth_minimum.data[i] = std::nextafter(static_cast<float>(1 / nearest[i]), 0.0f);
  }
  return map;
}

}  // namespace periplus::object_model::testing
