#include "common/object_model/model_export.h"

#include <octomap/OcTree.h>

#include <bit>
#include <cmath>
#include <sstream>

#include "common/core/error.h"

namespace periplus::object_model {

namespace {
static_assert(std::endian::native == std::endian::little, "the PLY below is written in the machine's order");

template <class T>
void append(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}
}  // namespace

std::string to_ply(const SurfaceMesh& mesh) {
  std::string out =
      "ply\nformat binary_little_endian 1.0\ncomment metres, world frame, z up\nelement vertex " + std::to_string(mesh.vertices.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face " +
      std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  out.reserve(out.size() + mesh.vertices.size() * 15 + mesh.triangles.size() * 13);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int n = 0; n < 3; ++n) append(out, mesh.vertices[i][n]);
    for (std::uint8_t c : mesh.colors[i]) append(out, c);
  }
  for (const auto& t : mesh.triangles) {
    append(out, std::uint8_t{3});
    for (std::uint32_t v : t) append(out, static_cast<std::int32_t>(v));
  }
  return out;
}

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
