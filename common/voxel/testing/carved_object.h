// The scene of the visibility benchmark: an object with a hollow, a handle and a foot in a grid that is carved by looks from around it,
// as it is in mid-run; solids around; views of it.
#pragma once

#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/voxel/occupancy_grid.h"
#include "common/voxel/visibility.h"

namespace periplus::voxel::testing {

struct CarvedObject {
  OccupancyGrid grid;
  std::vector<Occluder> occluders;            // a table below, small boxes around, walls far away
  std::vector<Eigen::Vector3i> watched;       // 500 known voxels, as landmarks
};

// Vertical view of 25 degrees, 640 x 480.
Pinhole carved_object_camera();

// `longest_side` of the object [m]; the grid is 1.4 times that each way, `cells` voxels. `looks`: 1 to 6.
CarvedObject carved_object(int cells, double longest_side, int looks);

// Of its middle or nearly: from 2 to 4 longest sides away for 0.5 m, from 1 to 2 for 2 m, none in a solid or near a voxel.
std::vector<Pose> views_of(const CarvedObject& object, double longest_side, int count, std::uint64_t seed);

}  // namespace periplus::voxel::testing
