#include "common/wire/knowledge.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/dds/codec_impl.h"
#include "common/wire/object_wire.h"
#include "common/wire/testing/environment_texts.h"

namespace periplus::wire {
namespace {

using namespace std::chrono_literals;

std::shared_ptr<dds::Node> node_on(int domain) {
  dds::NodeOptions options;
  options.name = "knowledge_test";
  options.domain = domain;
  return dds::Node::create(options);
}

msg::ObjectGrid grid_of_revision(std::uint32_t revision) {
  voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, 0.01));
  grid.revision = revision;
  return object_to_wire("cup", grid, {});
}

TEST(Knowledge, HearsEnvironmentAndRevisionsAndForgetsOldOnes) {
  const auto node = node_on(61);
  dds::Publisher<msg::Environment> environments(*node, "periplus/environment", dds::qos_latest());
  dds::Publisher<msg::ObjectGrid> objects(*node, "periplus/object", dds::qos_latest());
  const Knowledge knowledge(*node);
  EXPECT_EQ(knowledge.environment(10ms), nullptr);
  EXPECT_EQ(knowledge.object("cup", 1, 10ms), nullptr);

  const auto t = testing::environment_texts();
  msg::Environment broken = environment_to_wire("room", "name: [", t.robot_yaml, t.robot_urdf);
  environments.publish(broken);  // logged and dropped
  const msg::Environment good = environment_to_wire("room", t.scene_yaml, t.robot_yaml, t.robot_urdf);
  environments.publish(good);
  const auto known = knowledge.environment(10s);
  ASSERT_NE(known, nullptr);
  EXPECT_EQ(known->revision, good.revision().to_string());
  EXPECT_EQ(known->scene_id, "room");

  for (std::uint32_t r = 1; r <= 6; ++r) {
    objects.publish(grid_of_revision(r));
    const auto o = knowledge.object("cup", r, 10s);
    ASSERT_NE(o, nullptr) << r;
    EXPECT_EQ(o->grid->revision, r);
  }
  EXPECT_NE(knowledge.object("cup", 3, 10ms), nullptr);
  EXPECT_EQ(knowledge.object("cup", 2, 10ms), nullptr);  // four are kept
  EXPECT_EQ(knowledge.object("cup", 99, 10ms), nullptr);
  EXPECT_EQ(knowledge.object("pot", 6, 10ms), nullptr);

  // Begun again: what came before is void.
  objects.publish(grid_of_revision(4));
  for (int n = 0; n < 500 && knowledge.object("cup", 6, 0ms); ++n) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(knowledge.object("cup", 6, 10ms), nullptr);
  EXPECT_NE(knowledge.object("cup", 4, 10s), nullptr);
  EXPECT_NE(knowledge.object("cup", 3, 10ms), nullptr);
}

TEST(Knowledge, LateJoinersHearTheNewest) {
  const auto node = node_on(62);
  dds::Publisher<msg::ObjectGrid> objects(*node, "periplus/object", dds::qos_latest());
  objects.publish(grid_of_revision(1));
  objects.publish(grid_of_revision(2));
  const Knowledge knowledge(*node);
  EXPECT_NE(knowledge.object("cup", 2, 10s), nullptr);
}

}  // namespace
}  // namespace periplus::wire
