// Maps and clouds of other programs as object models. Metres; the axes of the file are the world's.
//
// A file is hostile until checked: headers, sizes, counts and numbers are judged, and at most 512 voxels a side are
// asked for, before memory is taken for them. Errors: bad_input with what is wrong.
//
// What comes of it has no views and no signed distances: its surface is its known voxels. Those carry as many points as
// make them known, so that a model that goes on learning keeps them until it sees through them.
#pragma once

#include <string>
#include <string_view>

#include "common/object_model/object_model.h"

namespace periplus::object_model {

// OctoMap's binary tree (.bt, "# Octomap OcTree binary file"): occupied leaves are known, free ones empty, all else within
// their bounds unknown. The voxel size is the file's resolution, the grid lies on its lattice.
ObjectModel import_bt(std::string_view file, const std::string& object_id);

// Point cloud (.pcd 0.7 or 0.6, `DATA ascii` or `DATA binary`): a voxel that holds a point is known, all else unknown. Fields x, y and z are needed,
// others are passed over; points whose x, y and z are all NaN are PCL's gaps and passed over too. The lattice has a corner in
// the origin. VIEWPOINT is where the sensor stood and moves nothing.
ObjectModel import_pcd(std::string_view file, const std::string& object_id, double voxel_size);

}  // namespace periplus::object_model
