// Which voxels of a grid a mesh fills and which its surface passes through.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/triangle_mesh.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::eyes_benchmark {

// Index as object_model::voxel_index().
struct VoxelTruth {
  std::vector<std::uint8_t> inside;    // 1: the voxel's centre lies in the mesh
  std::vector<std::uint8_t> touching;  // 1: a sample of the surface lies in the voxel
};

// Inside by the parity of crossings along the grid's axes; two of three decide, so that a small hole does no harm. `samples`
// area-uniform ones of the surface decide what it touches.
VoxelTruth voxel_truth(const mesh::TriangleMesh& mesh_W, const voxel::GridGeometry& geometry, std::size_t samples, std::uint64_t seed);

// Calls visit(voxel, its index in a VoxelTruth, its state) for each voxel of the grid.
template <class Visit>
void for_each_voxel(const voxel::OccupancyGrid& grid, Visit&& visit) {
  const voxel::GridGeometry& g = grid.geometry();
  for (int x = 0; x < g.size.x(); ++x)
    for (int y = 0; y < g.size.y(); ++y)
      for (int z = 0; z < g.size.z(); ++z) {
        const Eigen::Vector3i v(x, y, z);
        visit(v, voxel::voxel_index(g, v), grid.state(v));
      }
}

}  // namespace periplus::eyes_benchmark
