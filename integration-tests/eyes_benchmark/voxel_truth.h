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

}  // namespace periplus::eyes_benchmark
