#include "common/object_model/model_export.h"

#include <octomap/OcTree.h>

#include <cmath>
#include <sstream>

#include "common/core/error.h"
#include "common/geometry/ply.h"

namespace periplus::object_model {

std::string to_ply(const SurfaceMesh& mesh) { return encode_ply(mesh.vertices, mesh.colors, mesh.triangles, "metres, world frame, z up"); }

std::string export_ply(const ObjectModel& model, const CarvingSettings& settings) {
  const ModelState& s = model.state();
  return to_ply(extract_surface(s.grid, s.tsdf, settings.truncation_voxels * s.grid.geometry().voxel_size));
}

std::string export_bt(const ObjectModel& model) {
  const voxel::OccupancyGrid& grid = model.grid();
  const voxel::GridGeometry& g = grid.geometry();
  octomap::OcTree tree(g.voxel_size);
  Eigen::Vector3d lower = Eigen::Vector3d::Constant(1e9), upper = -lower;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d p =
        g.X_WG * (Eigen::Vector3d(c & 1 ? g.size.x() : 0, c & 2 ? g.size.y() : 0, c & 4 ? g.size.z() : 0) * g.voxel_size);
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  // OctoMap counts leaves from -2^15 to 2^15 - 1 about the origin.
  require((lower.array() > -32767 * g.voxel_size).all() && (upper.array() < 32766 * g.voxel_size).all(), ErrorCode::bad_input,
          "the object lies too far from the origin for an OctoMap of this voxel size");
  const Eigen::Vector3i first = (lower / g.voxel_size).array().floor().cast<int>();
  const Eigen::Vector3i last = (upper / g.voxel_size).array().ceil().cast<int>();
  for (int x = first.x(); x < last.x(); ++x)
    for (int y = first.y(); y < last.y(); ++y)
      for (int z = first.z(); z < last.z(); ++z) {
        const Eigen::Vector3d p = (Eigen::Vector3d(x, y, z).array() + 0.5) * g.voxel_size;
        const Eigen::Vector3i v = g.voxel_of(p);
        if (!g.contains(v)) continue;
        const voxel::VoxelState s = grid.state(v);
        if (s == voxel::VoxelState::unknown) continue;
        const octomap::OcTreeKey key(static_cast<octomap::key_type>(x + 32768), static_cast<octomap::key_type>(y + 32768),
                                     static_cast<octomap::key_type>(z + 32768));
        tree.updateNode(key, s != voxel::VoxelState::empty, true);
      }
  tree.updateInnerOccupancy();
  std::ostringstream out;
  require(tree.writeBinary(out), ErrorCode::internal, "OctoMap refused to write its tree");
  return out.str();
}

}  // namespace periplus::object_model
