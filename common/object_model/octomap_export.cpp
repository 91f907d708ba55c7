#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <sstream>

#include "common/core/error.h"
#include "common/object_model/model_export.h"

namespace periplus::object_model {

namespace {

enum class Leaf : std::uint8_t { unknown, free, occupied };

// Leaves of OctoMap's lattice by the cube, numbered as OctoMap numbers children: each eighth is a cube of half the side.
constexpr int kSide = 8, kHeight = 3;
struct Cube {
  std::array<Leaf, kSide * kSide * kSide> leaves;
  std::array<Eigen::Vector3i, kSide * kSide * kSide> voxels;  // that the leaves' centres lie in
};

// A tree whose nodes are set as far down as they differ: updateNode() makes every leaf, which for 512 voxels a side takes minutes.
template <class Base>
class Tree : public Base {
 public:
  using Node = typename Base::NodeType;
  using Base::Base;

  // The node of the cube that a leaf lies in, made where there is none.
  Node& cube_at(const octomap::OcTreeKey& key) {
    if (!this->root) {
      this->root = new Node;  // the tree's, as its own functions make it
      ++this->tree_size;
    }
    Node* node = this->root;
    for (int height = static_cast<int>(this->tree_depth) - 1; height >= kHeight; --height) {
      const unsigned child = octomap::computeChildIdx(key, height);
      node = this->nodeChildExists(node, child) ? this->getNodeChild(node, child) : this->createNodeChild(node, child);
    }
    return *node;
  }

  // Leaves first .. first + count - 1 of a cube, some of them not unknown. Calls occupied(node, voxel) for each occupied one.
  template <class Occupied>
  void fill(Node& node, const Cube& cube, std::size_t first, std::size_t count, Occupied& occupied) {
    const auto begin = cube.leaves.begin() + static_cast<std::ptrdiff_t>(first);
    if (count == 1 && *begin == Leaf::occupied) {
      node.setLogOdds(this->getProbHitLog());
      return occupied(node, cube.voxels[first]);
    }
    if (all_of(begin, count, Leaf::free)) return node.setLogOdds(this->getProbMissLog());
    for (std::size_t child = 0; child < 8; ++child) {
      const std::size_t part = count / 8, from = first + child * part;
      if (!all_of(cube.leaves.begin() + static_cast<std::ptrdiff_t>(from), part, Leaf::unknown))
        fill(*this->createNodeChild(&node, static_cast<unsigned>(child)), cube, from, part, occupied);
    }
  }

  // From the leaves up. OctoMap's own prune() ends at the first height where nothing is to be had.
  void prune_below(Node& node) {
    for (unsigned child = 0; child < 8; ++child)
      if (this->nodeChildExists(&node, child)) prune_below(*this->getNodeChild(&node, child));
    this->pruneNode(&node);
  }

  template <class Iterator>
  static bool all_of(Iterator begin, std::size_t count, Leaf leaf) {
    return std::all_of(begin, begin + static_cast<std::ptrdiff_t>(count), [leaf](Leaf l) { return l == leaf; });
  }
};

// The leaves whose centres lie in voxels that are not unknown.
template <class Base, class Occupied>
void fill(const voxel::OccupancyGrid& grid, Tree<Base>& tree, Occupied&& occupied) {
  const voxel::GridGeometry& g = grid.geometry();
  Eigen::Vector3d lower = Eigen::Vector3d::Constant(1e9), upper = -lower;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d p =
        g.X_WG * (Eigen::Vector3d(c & 1 ? g.size.x() : 0, c & 2 ? g.size.y() : 0, c & 4 ? g.size.z() : 0) * g.voxel_size);
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  // OctoMap counts leaves from -2^15 to 2^15 - 1 about the origin.
  constexpr int kOrigin = 1 << 15;
  require((lower.array() > -32767 * g.voxel_size).all() && (upper.array() < 32766 * g.voxel_size).all(), ErrorCode::bad_input,
          "the object lies too far from the origin for an OctoMap of this voxel size");
  const Eigen::Vector3i first = (lower / g.voxel_size).array().floor().cast<int>().unaryExpr([](int n) { return n & -kSide; });
  const Eigen::Vector3i last = (upper / g.voxel_size).array().ceil().cast<int>();
  // A leaf's centre [voxels] is to_voxels (x, y, z) + origin, moved so little that rounding decides about none on a border.
  const Eigen::Matrix3d to_voxels = g.X_WG.linear().transpose();
  const Eigen::Vector3d origin = to_voxels * (Eigen::Vector3d::Constant(0.5) - g.X_WG.translation() / g.voxel_size) + Eigen::Vector3d::Constant(1e-6);
  std::array<Eigen::Vector3d, kSide * kSide * kSide> steps;  // from a cube's first leaf to each [voxels]
  for (std::size_t n = 0; n < steps.size(); ++n) {
    Eigen::Vector3i leaf(0, 0, 0);
    for (int height = 0; height < kHeight; ++height)
      for (int axis = 0; axis < 3; ++axis) leaf[axis] += static_cast<int>(n >> (3 * height + axis) & 1) << height;
    steps[n] = to_voxels * leaf.cast<double>();
  }
  auto cube = std::make_unique<Cube>();
  for (int x = first.x(); x < last.x(); x += kSide) {
    for (int y = first.y(); y < last.y(); y += kSide) {
      for (int z = first.z(); z < last.z(); z += kSide) {
        const Eigen::Vector3d begin = to_voxels * Eigen::Vector3d(x, y, z) + origin;
        for (std::size_t n = 0; n < steps.size(); ++n) {
          const Eigen::Vector3d p = begin + steps[n];
          const bool inside = (p.array() >= 0).all() && (p.array() < g.size.cast<double>().array()).all();
          const Eigen::Vector3i v = inside ? Eigen::Vector3i(p.cast<int>()) : Eigen::Vector3i::Zero();
          const voxel::VoxelState state = inside ? grid.state(v) : voxel::VoxelState::unknown;
          cube->voxels[n] = v;
          cube->leaves[n] = state == voxel::VoxelState::unknown ? Leaf::unknown : state == voxel::VoxelState::empty ? Leaf::free : Leaf::occupied;
        }
        if (Tree<Base>::all_of(cube->leaves.begin(), cube->leaves.size(), Leaf::unknown)) continue;
        const auto key = [](int n) { return static_cast<octomap::key_type>(n + kOrigin); };
        tree.fill(tree.cube_at({key(x), key(y), key(z)}), *cube, 0, cube->leaves.size(), occupied);
      }
    }
  }
  // A ColorOcTree without a root follows its null pointer there.
  if (tree.size() == 0) return;
  tree.updateInnerOccupancy();
  tree.prune_below(*tree.getRoot());
}

using PlainTree = Tree<octomap::OcTree>;
using ColorTree = Tree<octomap::ColorOcTree>;

void fill(const voxel::OccupancyGrid& grid, PlainTree& tree) {
  fill(grid, tree, [](PlainTree::Node&, const Eigen::Vector3i&) {});
}

std::uint8_t octet(float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)); }

}  // namespace

std::string export_bt(const ObjectModel& model) {
  PlainTree tree(model.grid().geometry().voxel_size);
  fill(model.grid(), tree);
  std::ostringstream out;
  require(tree.writeBinary(out), ErrorCode::internal, "OctoMap refused to write its tree");
  return out.str();
}

std::string octomap_data(const voxel::OccupancyGrid& grid) {
  PlainTree tree(grid.geometry().voxel_size);
  fill(grid, tree);
  if (tree.size() == 0) return {};
  tree.toMaxLikelihood();
  std::ostringstream out;
  require(tree.writeBinaryData(out).good(), ErrorCode::internal, "OctoMap refused to write its tree");
  return out.str();
}

std::string export_ot(const ObjectModel& model) {
  ColorTree tree(model.grid().geometry().voxel_size);
  fill(model.grid(), tree, [&](ColorTree::Node& node, const Eigen::Vector3i& v) {
    const TsdfSample sample = model.state().tsdf.at(v);
    if (sample.color_weight > 0)
      node.setColor(octet(sample.r), octet(sample.g), octet(sample.b));
    else
      node.setColor(128, 128, 128);
  });
  std::ostringstream out;
  require(tree.write(out), ErrorCode::internal, "OctoMap refused to write its tree");
  return out.str();
}

}  // namespace periplus::object_model
