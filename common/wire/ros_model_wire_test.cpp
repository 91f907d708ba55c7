#include "common/wire/ros_model_wire.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace periplus::wire {
namespace {

TEST(RosModelWire, AnOctomapSaysWhatItsReadersAskFor) {
  const std::string data("\x00\xff\x7f", 3);
  const auto m = octomap_to_wire(1'500'000'002, "world", 0.025, data);
  EXPECT_EQ(m.header().stamp().sec(), 1);
  EXPECT_EQ(m.header().stamp().nanosec(), 500'000'002u);
  EXPECT_EQ(m.header().frame_id(), "world");
  EXPECT_TRUE(m.binary());
  EXPECT_EQ(m.id(), "OcTree");
  EXPECT_EQ(m.resolution(), 0.025);
  EXPECT_EQ(std::string(m.data().begin(), m.data().end()), data);
}

TEST(RosModelWire, APointCloudIsPclsPointXYZRGBNormalWithoutPadding) {
  object_model::SurfacePoints cloud;
  cloud.points = {{1, 2, 3}, {4, 5, 6}};
  cloud.normals = {{0, 0, 1}, {0, -1, 0}};
  cloud.colors = {{10, 20, 30}, {255, 0, 1}};
  const auto m = to_wire(7, "world", cloud);
  EXPECT_EQ(m.header().stamp().nanosec(), 7u);
  EXPECT_EQ(m.header().frame_id(), "world");
  EXPECT_EQ(m.height(), 1u);
  EXPECT_EQ(m.width(), 2u);
  EXPECT_EQ(m.point_step(), 28u);
  EXPECT_EQ(m.row_step(), 56u);
  EXPECT_FALSE(m.is_bigendian());
  EXPECT_TRUE(m.is_dense());
  const std::vector<std::string> names = {"x", "y", "z", "rgb", "normal_x", "normal_y", "normal_z"};
  ASSERT_EQ(m.fields().size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(m.fields()[i].name(), names[i]);
    EXPECT_EQ(m.fields()[i].offset(), 4 * i);
    EXPECT_EQ(m.fields()[i].datatype(), 7);  // FLOAT32
    EXPECT_EQ(m.fields()[i].count(), 1u);
  }
  ASSERT_EQ(m.data().size(), 56u);
  float second[7];
  std::memcpy(second, m.data().data() + 28, sizeof second);
  EXPECT_EQ(second[0], 4);
  EXPECT_EQ(second[2], 6);
  EXPECT_EQ(second[5], -1);
  const std::vector<std::uint8_t> rgb(m.data().begin() + 28 + 12, m.data().begin() + 28 + 16);
  EXPECT_EQ(rgb, (std::vector<std::uint8_t>{1, 0, 255, 0}));  // 0x00rrggbb, little-endian
  EXPECT_EQ(to_wire(7, "world", object_model::SurfacePoints{}).row_step(), 0u);
}

}  // namespace
}  // namespace periplus::wire
