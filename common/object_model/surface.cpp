#include "common/object_model/surface.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

namespace periplus::object_model {

namespace {

constexpr float kLeastWeight = 0.05f;

struct Vertex {
  Eigen::Vector3d sum{0, 0, 0};  // of crossings, in voxels
  int crossings = 0;
  Eigen::Vector3d color{0, 0, 0};
  double color_weight = 0;
};

}  // namespace

SurfaceMesh extract_surface(const voxel::OccupancyGrid& grid, const Tsdf& tsdf, double truncation) {
  const voxel::GridGeometry& g = grid.geometry();
  std::vector<Vertex> vertices;
  std::unordered_map<std::size_t, std::uint32_t> vertex_of_cell;  // cell: least corner, shifted by one
  const auto vertex = [&](const Eigen::Vector3i& cell) -> std::uint32_t {
    const std::size_t key = (static_cast<std::size_t>(cell.x() + 1) * (g.size.y() + 1) + (cell.y() + 1)) * (g.size.z() + 1) + (cell.z() + 1);
    const auto [it, fresh] = vertex_of_cell.try_emplace(key, static_cast<std::uint32_t>(vertices.size()));
    if (fresh) vertices.emplace_back();
    return it->second;
  };

  SurfaceMesh mesh;
  for (int x = 0; x < g.size.x(); ++x)
    for (int y = 0; y < g.size.y(); ++y)
      for (int z = 0; z < g.size.z(); ++z) {
        const Eigen::Vector3i a(x, y, z);
        const TsdfSample sa = tsdf.at(a);
        if (sa.weight <= kLeastWeight) continue;
        for (int axis = 0; axis < 3; ++axis) {
          Eigen::Vector3i b = a;
          ++b[axis];
          if (!g.contains(b)) continue;
          const TsdfSample sb = tsdf.at(b);
          if (sb.weight <= kLeastWeight || (sa.distance > 0) == (sb.distance > 0)) continue;
          if (std::abs(sa.distance - sb.distance) > 0.98 * truncation) continue;
          if (grid.state(a) != voxel::VoxelState::known && grid.state(b) != voxel::VoxelState::known) continue;
          const double t = sa.distance / (static_cast<double>(sa.distance) - sb.distance);
          Eigen::Vector3d crossing = a.cast<double>().array() + 0.5;
          crossing[axis] += t;

          // The four cells around the edge, in turn counter-clockwise about +axis.
          const int second = (axis + 1) % 3, third = (axis + 2) % 3;
          std::array<std::uint32_t, 4> quad{};
          const int steps[4][2] = {{-1, -1}, {0, -1}, {0, 0}, {-1, 0}};
          for (int n = 0; n < 4; ++n) {
            Eigen::Vector3i cell = a;
            cell[second] += steps[n][0];
            cell[third] += steps[n][1];
            quad[static_cast<std::size_t>(n)] = vertex(cell);
            Vertex& v = vertices[quad[static_cast<std::size_t>(n)]];
            v.sum += crossing;
            ++v.crossings;
            for (const TsdfSample* s : {&sa, &sb}) {
              v.color += Eigen::Vector3d(s->r, s->g, s->b) * s->color_weight;
              v.color_weight += s->color_weight;
            }
          }
          // Outside lies where the distance is positive.
          if (sa.distance > 0) std::swap(quad[1], quad[3]);
          mesh.triangles.push_back({quad[0], quad[1], quad[2]});
          mesh.triangles.push_back({quad[0], quad[2], quad[3]});
        }
      }

  mesh.vertices.reserve(vertices.size());
  mesh.colors.reserve(vertices.size());
  for (const Vertex& v : vertices) {
    mesh.vertices.push_back((g.X_WG * (v.sum / v.crossings * g.voxel_size)).cast<float>());
    std::array<std::uint8_t, 3> rgb{128, 128, 128};
    if (v.color_weight > 0)
      for (int c = 0; c < 3; ++c)
        rgb[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::clamp(v.color[c] / v.color_weight + 0.5, 0.0, 255.0));
    mesh.colors.push_back(rgb);
  }
  return mesh;
}

}  // namespace periplus::object_model
