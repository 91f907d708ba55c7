#include "common/object_model/model_export.h"

#include <gtest/gtest.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <memory>
#include <sstream>

#include "common/core/error.h"
#include "common/object_model/testing/exported_model.h"

namespace periplus::object_model {
namespace {

using namespace testing;

// The voxel that a leaf's centre lies in; on a border, the upper one.
Eigen::Vector3i voxel_at(const voxel::GridGeometry& g, const Eigen::Vector3d& center) {
  return g.voxel_of(center + g.X_WG.linear() * Eigen::Vector3d::Constant(1e-6 * g.voxel_size));
}

TEST(OctomapExport, OctoMapReadsTheTreeAsTheGridIs) {
  for (const double yaw : {0.0, 0.5}) {
    const ObjectModel model = model_of({}, yaw);
    std::istringstream in(export_bt(model));
    octomap::OcTree tree(0.1);
    ASSERT_TRUE(tree.readBinary(in));
    EXPECT_DOUBLE_EQ(tree.getResolution(), 0.02);
    // Leaves are asked at their own centres.
    int occupied = 0, empty = 0, unknown = 0;
    for (int x = -20; x < 20; ++x)
      for (int y = -20; y < 20; ++y)
        for (int z = 30; z < 70; ++z) {
          const Eigen::Vector3d p = (Eigen::Vector3d(x, y, z).array() + 0.5) * 0.02;
          const Eigen::Vector3i v = voxel_at(model.grid().geometry(), p);
          const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
          if (!model.grid().geometry().contains(v) || model.grid().state(v) == voxel::VoxelState::unknown) {
            EXPECT_EQ(node, nullptr);
            ++unknown;
          } else {
            ASSERT_NE(node, nullptr);
            EXPECT_EQ(tree.isNodeOccupied(node), model.grid().state(v) != voxel::VoxelState::empty);
            ++(tree.isNodeOccupied(node) ? occupied : empty);
          }
        }
    EXPECT_GT(occupied, 200);
    EXPECT_GT(empty, 1000);
    EXPECT_GT(unknown, 100);
  }
}

// The same bytes as of a tree of leaves, whose equal ones OctoMap itself has put together.
TEST(OctomapExport, WritesTheTreeThatOctoMapMakesOfTheLeaves) {
  constexpr int kCells = 70;
  constexpr double kVoxel = 0.01;
  for (const double yaw : {0.0, 0.3}) {
    voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(make_pose({-0.123, 0.2, 0.3}, rotation_from_yaw_pitch_roll(yaw, 0, 0)), Eigen::Vector3d::Constant(kCells * kVoxel), kVoxel));
    for (int x = 0; x < kCells; ++x)
      for (int y = 0; y < kCells; ++y)
        for (int z = 0; z < kCells; ++z) {
          const double r = Eigen::Vector3d(x - 30, y - 35, z - 40).norm();
          grid.set_state({x, y, z}, r > 29 ? voxel::VoxelState::empty : r > 26 ? voxel::VoxelState::known : r > 19 ? voxel::VoxelState::unknown : voxel::VoxelState::environment);
        }
    octomap::OcTree tree(kVoxel);
    for (int x = -100; x < 100; ++x)
      for (int y = -100; y < 100; ++y)
        for (int z = -100; z < 100; ++z) {
          const Eigen::Vector3d p = (Eigen::Vector3d(x, y, z).array() + 0.5) * kVoxel;
          const Eigen::Vector3i v = voxel_at(grid.geometry(), p);
          if (grid.geometry().contains(v) && grid.state(v) != voxel::VoxelState::unknown) tree.updateNode(p.x(), p.y(), p.z(), grid.state(v) != voxel::VoxelState::empty, true);
        }
    tree.updateInnerOccupancy();
    tree.toMaxLikelihood();
    tree.prune();
    std::ostringstream expected;
    tree.writeBinaryData(expected);
    EXPECT_GT(expected.str().size(), 10000u);
    EXPECT_EQ(octomap_data(grid), expected.str());
  }
}

TEST(OctomapExport, TheColouredTreeHoldsTheSameLeaves) {
  const ObjectModel model = model_of({});
  std::istringstream bt(export_bt(model)), ot(export_ot(model));
  octomap::OcTree plain(0.1);
  ASSERT_TRUE(plain.readBinary(bt));
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(ot));
  auto* colored = dynamic_cast<octomap::ColorOcTree*>(read.get());
  ASSERT_NE(colored, nullptr);
  colored->expand();
  plain.expand();
  EXPECT_EQ(colored->getNumLeafNodes(), plain.getNumLeafNodes());
  int red = 0, occupied = 0;
  for (auto leaf = colored->begin_leafs(); leaf != colored->end_leafs(); ++leaf) {
    const octomap::OcTreeNode* other = plain.search(leaf.getKey());
    ASSERT_NE(other, nullptr);
    ASSERT_EQ(plain.isNodeOccupied(other), colored->isNodeOccupied(*leaf));
    if (!colored->isNodeOccupied(*leaf)) continue;
    ++occupied;
    red += leaf->getColor().r > 150 && leaf->getColor().b < 80;
  }
  EXPECT_GT(red, occupied / 2);
}

TEST(OctomapExport, RefusesWhatOctoMapCannotAddress) {
  ObjectBox box;
  box.X_WB.translation() = Eigen::Vector3d(500, 0, 0);
  box.size = {0.1, 0.1, 0.1};
  EXPECT_THROW(export_bt(ObjectModel("far", box, 0.01, {})), Error);
}

}  // namespace
}  // namespace periplus::object_model
