#include "common/wire/knowledge.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/dds/codec_impl.h"
#include "common/dds/testing/test_domain.h"
#include "common/wire/object_publisher.h"
#include "common/wire/object_wire.h"
#include "common/wire/testing/environment_texts.h"
#include "common/wire/testing/random_grid.h"

namespace periplus::wire {
namespace {

using namespace std::chrono_literals;

std::shared_ptr<dds::Node> node_on(int domain) {
  dds::NodeOptions options;
  options.name = "knowledge_test";
  options.domain = domain;
  return dds::Node::create(options);
}

// Of 3 x 2 x 2 chunks, one of which changes from each revision to the next.
voxel::OccupancyGrid grid_of_revision(std::uint32_t revision) {
  voxel::OccupancyGrid grid = testing::random_grid({140, 66, 82}, 1, revision);
  testing::change(grid, 50, revision, {0, 0, 0}, {64, 64, 64});
  return grid;
}

TEST(Knowledge, HearsEnvironmentAndRevisionsAndForgetsOldOnes) {
  const dds::testing::TestDomain domain;
  const auto node = node_on(domain.id());
  dds::Publisher<msg::Environment> environments(*node, "periplus/environment", dds::qos_latest());
  ObjectPublisher objects(*node);
  const Knowledge knowledge(*node);
  EXPECT_EQ(knowledge.environment("none", 10ms), nullptr);
  EXPECT_EQ(knowledge.object("cup", 1, 10ms), nullptr);

  const auto t = testing::environment_texts();
  msg::Environment broken = environment_to_wire("room", "name: [", t.robot_yaml, t.robot_urdf);
  environments.publish(broken);  // logged and dropped
  const msg::Environment good = environment_to_wire("room", t.scene_yaml, t.robot_yaml, t.robot_urdf);
  environments.publish(good);
  const auto known = knowledge.environment(good.revision().to_string(), 10s);
  ASSERT_NE(known, nullptr);
  EXPECT_EQ(known->revision, good.revision().to_string());
  EXPECT_EQ(known->scene_id, "room");

  for (std::uint32_t r = 1; r <= 6; ++r) {
    objects.publish("cup", grid_of_revision(r));
    const auto o = knowledge.object("cup", r, 10s);
    ASSERT_NE(o, nullptr) << r;
    EXPECT_EQ(o->grid->revision, r);
  }
  EXPECT_NE(knowledge.object("cup", 3, 10ms), nullptr);
  EXPECT_EQ(knowledge.object("cup", 2, 10ms), nullptr);  // four are kept
  EXPECT_EQ(knowledge.object("cup", 99, 10ms), nullptr);
  EXPECT_EQ(knowledge.object("pot", 6, 10ms), nullptr);

  // Begun again: what came before is void.
  objects.publish("cup", grid_of_revision(4));
  for (int n = 0; n < 500 && knowledge.object("cup", 6, 0ms); ++n) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(knowledge.object("cup", 6, 10ms), nullptr);
  EXPECT_NE(knowledge.object("cup", 4, 10s), nullptr);
  EXPECT_NE(knowledge.object("cup", 3, 10ms), nullptr);
}

TEST(Knowledge, GivesTheEnvironmentAskedForAndNoOther) {
  const dds::testing::TestDomain domain;
  const auto node = node_on(domain.id());
  dds::Publisher<msg::Environment> environments(*node, "periplus/environment", dds::qos_latest());
  const Knowledge knowledge(*node);
  const auto t = testing::environment_texts();
  const auto publish = [&](int n, const std::string& scene_id = "room") {
    const msg::Environment e =
        environment_to_wire(scene_id, t.scene_yaml + "# " + std::to_string(n) + "\n", t.robot_yaml, t.robot_urdf);
    environments.publish(e);
    return e.revision().to_string();
  };
  const std::string first = publish(0);
  ASSERT_NE(knowledge.environment(first, 10s), nullptr);
  const std::string second = publish(1);
  ASSERT_NE(knowledge.environment(second, 10s), nullptr);
  ASSERT_NE(knowledge.environment(first, 0ms), nullptr);
  EXPECT_EQ(knowledge.environment(first, 0ms)->revision, first);   // the later one of the same scene does not take its place
  EXPECT_EQ(knowledge.environment("elsewhere", 10ms), nullptr);
  try {
    knowledge.environment_or_throw("elsewhere", ErrorCode::walk_revision_not_here, 10ms);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::walk_revision_not_here);
    EXPECT_NE(std::string(e.what()).find("model/publish"), std::string::npos) << e.what();
  }
  // Heard of again, the first one outlives those that came after it; the oldest goes when there are too many.
  publish(0);
  for (int n = 2; n < 5; ++n) ASSERT_NE(knowledge.environment(publish(n, "room" + std::to_string(n)), 10s), nullptr) << n;
  EXPECT_NE(knowledge.environment(first, 0ms), nullptr);
  EXPECT_EQ(knowledge.environment(second, 0ms), nullptr);
}

TEST(Knowledge, ForgetsTheObjectsHeardOfLongestAgo) {
  const dds::testing::TestDomain domain;
  const auto node = node_on(domain.id());
  ObjectPublisher objects(*node);
  const Knowledge knowledge(*node);
  const auto name = [](std::size_t n) { return "cup" + std::to_string(n); };
  for (std::size_t n = 0; n < Knowledge::kObjectsKept; ++n) {
    objects.publish(name(n), grid_of_revision(1));
    ASSERT_NE(knowledge.object(name(n), 1, 10s), nullptr) << n;
  }
  objects.publish(name(0), grid_of_revision(2));
  ASSERT_NE(knowledge.object(name(0), 2, 10s), nullptr);
  objects.publish("one-more", grid_of_revision(1));
  ASSERT_NE(knowledge.object("one-more", 1, 10s), nullptr);
  EXPECT_NE(knowledge.object(name(0), 2, 0ms), nullptr);
  EXPECT_EQ(knowledge.object(name(1), 1, 0ms), nullptr);
}

// The largest grids: four revisions of one and one of another are held, and no more.
TEST(Knowledge, ForgetsObjectsRatherThanHoldTooMuch) {
  const dds::testing::TestDomain domain;
  const auto node = node_on(domain.id());
  ObjectPublisher objects(*node);
  const Knowledge knowledge(*node);
  voxel::OccupancyGrid grid(testing::geometry({512, 512, 512}, 0.004));
  const std::size_t octets = 3 * sizeof(std::uint64_t) * grid.occupied().size();
  ASSERT_EQ(Knowledge::kMostOctets / octets, 5u);
  const auto publish = [&](const char* name, std::uint32_t revision) {
    grid.revision = revision;
    objects.publish(name, grid);
    return knowledge.object(name, revision, 30s) != nullptr;
  };
  for (std::uint32_t r = 1; r <= 4; ++r) ASSERT_TRUE(publish("hall", r)) << r;
  ASSERT_TRUE(publish("dome", 1));
  EXPECT_NE(knowledge.object("hall", 1, 0ms), nullptr);
  ASSERT_TRUE(publish("dome", 2));
  EXPECT_EQ(knowledge.object("hall", 4, 0ms), nullptr);
  EXPECT_NE(knowledge.object("dome", 1, 0ms), nullptr);
  EXPECT_TRUE(publish("hall", 5)) << "what goes out again comes back";
}

}  // namespace
}  // namespace periplus::wire
