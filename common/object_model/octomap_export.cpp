#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/core/error.h"
#include "common/object_model/model_export.h"

namespace periplus::object_model {

namespace {

// Calls visit(key, voxel, state) for each leaf of OctoMap's lattice whose centre lies in a voxel that is not unknown. Prunes the tree after
// every sixteen layers of leaves: those of 512 voxels a side would take gigabytes.
template <class Tree, class Visit>
void for_each_leaf(const voxel::OccupancyGrid& grid, Tree& tree, Visit&& visit) {
  const voxel::GridGeometry& g = grid.geometry();
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
  for (int x = first.x(); x < last.x(); ++x) {
    if (x % 16 == 0 && tree.size() > 0) tree.prune();
    for (int y = first.y(); y < last.y(); ++y)
      for (int z = first.z(); z < last.z(); ++z) {
        const Eigen::Vector3d p = (Eigen::Vector3d(x, y, z).array() + 0.5) * g.voxel_size;
        const Eigen::Vector3i v = g.voxel_of(p);
        if (!g.contains(v)) continue;
        const voxel::VoxelState s = grid.state(v);
        if (s == voxel::VoxelState::unknown) continue;
        visit(octomap::OcTreeKey(static_cast<octomap::key_type>(x + 32768), static_cast<octomap::key_type>(y + 32768),
                                 static_cast<octomap::key_type>(z + 32768)),
              v, s);
      }
  }
}

octomap::OcTree tree_of(const voxel::OccupancyGrid& grid) {
  octomap::OcTree tree(grid.geometry().voxel_size);
  for_each_leaf(grid, tree, [&](const octomap::OcTreeKey& key, const Eigen::Vector3i&, voxel::VoxelState s) {
    tree.updateNode(key, s != voxel::VoxelState::empty, true);
  });
  tree.updateInnerOccupancy();
  return tree;
}

std::uint8_t octet(float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)); }

}  // namespace

std::string export_bt(const ObjectModel& model) {
  octomap::OcTree tree = tree_of(model.grid());
  std::ostringstream out;
  require(tree.writeBinary(out), ErrorCode::internal, "OctoMap refused to write its tree");
  return out.str();
}

std::string octomap_data(const voxel::OccupancyGrid& grid) {
  octomap::OcTree tree = tree_of(grid);
  if (tree.size() == 0) return {};
  tree.toMaxLikelihood();
  tree.prune();
  std::ostringstream out;
  require(tree.writeBinaryData(out).good(), ErrorCode::internal, "OctoMap refused to write its tree");
  return out.str();
}

std::string export_ot(const ObjectModel& model) {
  const voxel::GridGeometry& g = model.grid().geometry();
  octomap::ColorOcTree tree(g.voxel_size);
  for_each_leaf(model.grid(), tree, [&](const octomap::OcTreeKey& key, const Eigen::Vector3i& v, voxel::VoxelState s) {
    octomap::ColorOcTreeNode* node = tree.updateNode(key, s != voxel::VoxelState::empty, true);
    const TsdfSample sample = model.state().tsdf.at(v);
    if (s == voxel::VoxelState::empty) return;
    if (sample.color_weight > 0)
      node->setColor(octet(sample.r), octet(sample.g), octet(sample.b));
    else
      node->setColor(128, 128, 128);
  });
  // A ColorOcTree without a root follows its null pointer there.
  if (tree.size() > 0) {
    tree.updateInnerOccupancy();
    tree.prune();
  }
  std::ostringstream out;
  require(tree.write(out), ErrorCode::internal, "OctoMap refused to write its tree");
  return out.str();
}

}  // namespace periplus::object_model
