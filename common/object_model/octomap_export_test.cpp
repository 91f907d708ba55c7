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
          const Eigen::Vector3i v = model.grid().geometry().voxel_of(p);
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
