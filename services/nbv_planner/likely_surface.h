// Where the rest of the surface is to be expected. A surface goes on where it was last seen: unknown voxels near known
// ones are likely to hold it, those far away are mostly the shadow that the object threw. To count them all draws the
// camera to where the shadow shows most of its own, arbitrary outside; views are better judged as if the shadow were empty.
#pragma once

#include "common/voxel/occupancy_grid.h"

namespace periplus::nbv {

// The grid without those unknown voxels that are farther than `within` voxels from all known ones; they are empty in it. Distance is
// counted in steps of a voxel, by turns across a face and across a face, edge or corner: between 1 and 1.16 times `within` is
// reached, by direction. Nothing known, or `within` 0: the grid as it is.
voxel::OccupancyGrid likely_surface(const voxel::OccupancyGrid& grid, int within);

}  // namespace periplus::nbv
