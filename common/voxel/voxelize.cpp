#include "common/voxel/voxelize.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/core/error.h"

namespace periplus::voxel {
namespace {

using Triangle = std::array<Eigen::Vector3d, 3>;  // grid frame [voxels]

// Of a cube of side 1.
bool touches(const Triangle& t, const Eigen::Vector3d& center) {
  const Eigen::Vector3d p[3] = {t[0] - center, t[1] - center, t[2] - center};
  const auto separates = [&](const Eigen::Vector3d& axis) {
    const double a = axis.dot(p[0]), b = axis.dot(p[1]), c = axis.dot(p[2]), r = 0.5 * axis.lpNorm<1>() + 1e-9;
    return std::min({a, b, c}) > r || std::max({a, b, c}) < -r;
  };
  const Eigen::Vector3d edges[3] = {p[1] - p[0], p[2] - p[1], p[0] - p[2]};
  for (int a = 0; a < 3; ++a) {
    if (separates(Eigen::Vector3d::Unit(a))) return false;
  }
  if (separates(edges[0].cross(edges[1]))) return false;
  for (const Eigen::Vector3d& e : edges) {
    for (int a = 0; a < 3; ++a) {
      if (separates(e.cross(Eigen::Vector3d::Unit(a)))) return false;
    }
  }
  return true;
}

}  // namespace

void mark_environment(const std::vector<Eigen::Vector3d>& vertices_W, const std::vector<Eigen::Vector3i>& triangles, OccupancyGrid& grid) {
  const GridGeometry& g = grid.geometry();
  const Pose X_GW = g.X_WG.inverse();
  std::vector<Eigen::Vector3d> vertices;
  vertices.reserve(vertices_W.size());
  for (const auto& p : vertices_W) {
    require(p.allFinite(), ErrorCode::not_finite, "a vertex of a mesh has a number that is not finite");
    vertices.push_back(X_GW * p / g.voxel_size);
  }
  for (const Eigen::Vector3i& index : triangles) {
    require((index.array() >= 0).all() && (index.array() < static_cast<int>(vertices.size())).all(), ErrorCode::bad_input, "a triangle names a vertex that the mesh does not have");
    const Triangle t{vertices[static_cast<std::size_t>(index[0])], vertices[static_cast<std::size_t>(index[1])], vertices[static_cast<std::size_t>(index[2])]};
    const Eigen::Array3d size = g.size.cast<double>();
    const Eigen::Array3d low = t[0].array().min(t[1].array()).min(t[2].array()), high = t[0].array().max(t[1].array()).max(t[2].array());
    if ((high < 0).any() || (low > size).any()) continue;
    // A voxel more on each side, for triangles that lie on a boundary; within the grid.
    const Eigen::Array3i first = (low.max(0.0) - 1e-9).floor().max(0.0).cast<int>(), last = (high.min(size) + 1e-9).floor().min(size - 1).cast<int>();
    for (int x = first.x(); x <= last.x(); ++x) {
      for (int y = first.y(); y <= last.y(); ++y) {
        for (int z = first.z(); z <= last.z(); ++z) {
          if (touches(t, Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5))) grid.set_state({x, y, z}, VoxelState::environment);
        }
      }
    }
  }
}

}  // namespace periplus::voxel
