// A grid of half the resolution: renderings of it take a quarter of the time.
#pragma once

#include "common/voxel/occupancy_grid.h"

namespace periplus::voxel {

// Voxel (i, j, k) stands for the eight from (2 i, 2 j, 2 k) on; beyond the size all is empty. It is occupied if at least four
// of them are: walls keep their places in the mean, and a sheet one voxel thick stays. Of those occupied, as many as half make it
// environment, else unknown, else known. Same X_WG and revision.
OccupancyGrid coarsen(const OccupancyGrid& grid);

}  // namespace periplus::voxel
