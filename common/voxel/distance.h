// Distances between voxels' centres over a whole grid.
#pragma once

#include <vector>

#include "common/voxel/occupancy_grid.h"

namespace periplus::voxel {

// For each voxel, by (x * ny + y) * nz + z, the Euclidean distance to the nearest voxel of that state [voxels]; `farthest` where
// there is none nearer. Exact: the lower envelopes of P. Felzenszwalb and D. Huttenlocher, "Distance transforms of sampled
// functions", Theory of Computing 8, 2012, one axis after the other.
std::vector<float> distance_to_state(const OccupancyGrid& grid, VoxelState state, double farthest);

}  // namespace periplus::voxel
