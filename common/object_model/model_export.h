// A model for other programs.
#pragma once

#include <string>

#include "common/object_model/object_model.h"
#include "common/object_model/surface.h"

namespace periplus::object_model {

// Binary little-endian PLY: x y z [m, world frame], red green blue, triangles.
std::string to_ply(const SurfaceMesh& mesh);
// The model's coloured surface.
std::string export_ply(const ObjectModel& model, const CarvingSettings& settings = {});

// OctoMap binary tree (.bt) with leaves of the voxel size on OctoMap's own lattice (axes of the world, origin a leaf's
// corner): occupied where the voxel at a leaf's centre is known or environment, free where it is empty, unknown elsewhere.
std::string export_bt(const ObjectModel& model);

}  // namespace periplus::object_model
