// What a ROS 2 tool makes of the model server's topics: OctoMap itself reads the tree, points are found by the fields' offsets.
#include "services/model_server/ros_topics_service.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <sstream>

#include "common/dds/codec_impl.h"
#include "common/dds/testing/eventually.h"
#include "common/dds/testing/vendor_test.h"
#include "common/object_model/model_export.h"
#include "common/object_model/testing/sphere_views.h"
#include "idl/ros2.h"

namespace periplus::model {
namespace {

using Octomap = octomap_msgs::msg::dds_::Octomap_;
using PointCloud2 = sensor_msgs::msg::dds_::PointCloud2_;
using object_model::ObjectModel;
using namespace std::chrono_literals;

std::shared_ptr<ObjectModel> ball(int views) {
  const object_model::testing::Sphere sphere;
  auto model = std::make_shared<ObjectModel>("ball", object_model::testing::box_around(sphere), 0.025, object_model::Surroundings{});
  for (int n = 0; n < views; ++n) model->integrate(object_model::testing::ideal_view(sphere, n, 6), {}, {});
  return model;
}

// The last sample of a topic.
template <class Message>
class Last {
 public:
  Last(dds::Node& node, const char* topic)
      : in_(node, topic, dds::qos_stream(4), [this](const Message& m) {  // volatile, as RViz asks by default
          const std::lock_guard lock(mutex_);
          last_ = m;
        }) {}
  // Of that stamp, or the last that came.
  Message wait(unsigned nanosec) {
    dds::testing::eventually([&] {
      const std::lock_guard lock(mutex_);
      return last_.header().stamp().nanosec() == nanosec && !last_.header().frame_id().empty();
    });
    const std::lock_guard lock(mutex_);
    return last_;
  }

 private:
  std::mutex mutex_;
  Message last_;
  dds::Subscriber<Message> in_;
};

// As octomap_msgs/conversions.h reads it.
void expect_grid(const Octomap& m, const voxel::OccupancyGrid& grid) {
  EXPECT_EQ(m.header().frame_id(), "world");
  EXPECT_TRUE(m.binary());
  EXPECT_EQ(m.id(), "OcTree");
  octomap::OcTree tree(m.resolution());
  if (!m.data().empty()) {
    std::stringstream data;
    data.write(m.data().data(), static_cast<std::streamsize>(m.data().size()));
    tree.readBinaryData(data);
    ASSERT_TRUE(data.good());
  }
  const voxel::GridGeometry& g = grid.geometry();
  EXPECT_EQ(m.resolution(), g.voxel_size);
  std::map<voxel::VoxelState, int> compared;
  object_model::testing::for_each_voxel(g, [&](const Eigen::Vector3i& v) {
    // Grid and OctoMap's lattice coincide here.
    const Eigen::Vector3d p = g.center_world(v);
    const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
    const voxel::VoxelState state = grid.state(v);
    ++compared[state];
    ASSERT_EQ(node == nullptr, state == voxel::VoxelState::unknown) << v.transpose();
    if (node) {
      ASSERT_EQ(tree.isNodeOccupied(node), state != voxel::VoxelState::empty) << v.transpose();
    }
  });
  EXPECT_GT(compared[voxel::VoxelState::unknown], 100);
  if (grid.revision > 0) {
    EXPECT_GT(compared[voxel::VoxelState::known], 100);
    EXPECT_GT(compared[voxel::VoxelState::empty], 1000);
  }
}

void expect_points(const PointCloud2& m, const object_model::SurfacePoints& cloud) {
  EXPECT_EQ(m.header().frame_id(), "world");
  ASSERT_EQ(m.width() * m.height(), cloud.points.size());
  ASSERT_EQ(m.data().size(), m.row_step() * m.height());
  EXPECT_EQ(m.row_step(), m.point_step() * m.width());
  EXPECT_FALSE(m.is_bigendian());
  std::map<std::string, std::size_t> offset;
  for (const auto& field : m.fields()) {
    EXPECT_EQ(field.datatype(), 7) << "FLOAT32";
    EXPECT_EQ(field.count(), 1u);
    ASSERT_LE(field.offset() + 4, m.point_step());
    offset[field.name()] = field.offset();
  }
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const auto bytes = [&](const char* field) { return m.data().data() + i * m.point_step() + offset.at(field); };
    const auto vector = [&](const char* x, const char* y, const char* z) {
      Eigen::Vector3f v;
      std::memcpy(&v.x(), bytes(x), 4);
      std::memcpy(&v.y(), bytes(y), 4);
      std::memcpy(&v.z(), bytes(z), 4);
      return v;
    };
    ASSERT_EQ(vector("x", "y", "z"), cloud.points[i]);
    ASSERT_EQ(vector("normal_x", "normal_y", "normal_z"), cloud.normals[i]);
    const std::uint8_t* bgr = bytes("rgb");
    ASSERT_EQ((std::array<std::uint8_t, 3>{bgr[2], bgr[1], bgr[0]}), cloud.colors[i]);
  }
}

class RosTopicsTest : public dds::testing::VendorTest {};

TEST_P(RosTopicsTest, ToolsReadTheModelAsItIs) {
  const auto server = node(), tool = node();
  RosTopics topics(*server);
  topics.offer(ball(0));
  const auto seen = ball(3);
  ASSERT_GT(object_model::surface_points(*seen).points.size(), 200u);
  topics.offer(seen);  // before anybody reads
  Last<Octomap> octomap(*tool, "rt/octomap_binary");
  Last<PointCloud2> points(*tool, "rt/object_points");
  expect_grid(octomap.wait(1002), seen->grid());
  expect_points(points.wait(1002), object_model::surface_points(*seen));
  const auto more = ball(5);
  topics.offer(more);
  expect_grid(octomap.wait(1004), more->grid());
  expect_points(points.wait(1004), object_model::surface_points(*more));
  // All unknown: a tree without a node, and no points.
  topics.offer(ball(0));
  const Octomap empty = octomap.wait(0);
  EXPECT_TRUE(empty.data().empty());
  expect_grid(empty, ball(0)->grid());
  EXPECT_EQ(points.wait(0).width(), 0u);
}

// Each with volatile samples, for which the writer keeps nothing.
TEST_P(RosTopicsTest, WhoComesWhileOthersReadHasTheNewestToo) {
  const auto server = node(), tool = node(), later = node();
  RosTopics topics(*server);
  const auto seen = ball(2);
  topics.offer(seen);
  Last<PointCloud2> first(*tool, "rt/object_points");
  expect_points(first.wait(1001), object_model::surface_points(*seen));
  Last<PointCloud2> second(*later, "rt/object_points");
  expect_points(second.wait(1001), object_model::surface_points(*seen));
}

TEST_P(RosTopicsTest, AModelThatOctoMapCannotHoldIsLeftOut) {
  const auto server = node(), tool = node();
  RosTopics topics(*server);
  Last<PointCloud2> points(*tool, "rt/object_points");
  Last<Octomap> octomap(*tool, "rt/octomap_binary");
  object_model::ObjectBox box;
  box.X_WB.translation() = Eigen::Vector3d(500, 0, 0);
  box.size = {0.1, 0.1, 0.1};
  topics.offer(std::make_shared<ObjectModel>("far", box, 0.01, object_model::Surroundings{}));
  EXPECT_EQ(points.wait(0).header().frame_id(), "world");
  const auto seen = ball(1);
  topics.offer(seen);
  expect_grid(octomap.wait(1000), seen->grid());
}

INSTANTIATE_TEST_SUITE_P(Vendors, RosTopicsTest, dds::testing::each_vendor());

}  // namespace
}  // namespace periplus::model
