#include "common/wire/object_publisher.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/testing/vendor_test.h"
#include "common/wire/knowledge.h"
#include "common/wire/testing/random_grid.h"

namespace periplus::wire {
namespace {

using namespace std::chrono_literals;

// Of 3 x 2 x 2 chunks, one of which changes from each revision to the next.
voxel::OccupancyGrid grid_of(std::uint32_t revision) {
  voxel::OccupancyGrid grid = testing::random_grid({140, 66, 82}, 1, revision);
  testing::change(grid, 50, revision, {0, 0, 0}, {64, 64, 64});
  return grid;
}

// A publisher of the first vendor, a reader of the second.
class ObjectPublisherTest : public ::testing::TestWithParam<std::pair<std::string, std::string>> {
 protected:
  std::shared_ptr<dds::Node> node(const std::string& vendor) const {
    dds::NodeOptions options;
    options.name = "object_publisher_test";
    options.vendor = vendor;
    options.domain = domain_.id();
    return dds::Node::create(options);
  }
  dds::testing::TestDomain domain_;
};

TEST_P(ObjectPublisherTest, LateJoinersHearAllOfTheNewestAndEarlyOnesEachRevision) {
  const auto writer = node(GetParam().first), reader = node(GetParam().second);
  ObjectPublisher objects(*writer);
  const Knowledge early(*reader);
  const std::vector<Pose> views(2, look_at({1, 0.5, 1.2}, {0, 0, 0.7}));
  const std::vector<object_model::Landmark> landmarks(1500, {{1, 2, 3}, {0, 0, 1}, 0.02});
  for (std::uint32_t revision = 1; revision <= 5; ++revision) {
    for (const char* name : {"cup", "pot", "jug"}) {
      const auto sent = objects.publish(name, grid_of(revision), landmarks, views);
      EXPECT_EQ(sent.chunks, revision == 1 ? 14u : 1u);
      EXPECT_GT(sent.octets, 200u);
      const auto here = early.object(name, revision, 10s);
      ASSERT_NE(here, nullptr) << name << revision;
      EXPECT_TRUE(testing::same_voxels(*here->grid, grid_of(revision)));
    }
  }
  const auto late_reader = node(GetParam().second);
  const Knowledge late(*late_reader);
  for (const char* name : {"cup", "pot", "jug"}) {
    const auto here = late.object(name, 5, 10s);
    ASSERT_NE(here, nullptr) << name;
    EXPECT_TRUE(testing::same_voxels(*here->grid, grid_of(5)));
    EXPECT_EQ(here->landmarks.size(), 1500u);
    EXPECT_EQ(here->views.size(), 2u);
    EXPECT_EQ(late.object(name, 4, 0ms), nullptr);
  }
  EXPECT_EQ(objects.publish("cup", grid_of(5), landmarks, views, true).chunks, 14u);
}

// As large as grids may be: hundreds of keys.
TEST_P(ObjectPublisherTest, TheLargestGridReachesALateJoiner) {
  const auto writer = node(GetParam().first), reader = node(GetParam().second);
  ObjectPublisher objects(*writer);
  voxel::OccupancyGrid grid(testing::geometry({512, 512, 512}, 0.004));
  grid.revision = 1;
  testing::change(grid, 200000, 1);
  EXPECT_EQ(objects.publish("statue", grid).chunks, kMostVoxelChunks);
  grid.revision = 2;
  testing::change(grid, 100, 2, {0, 0, 0}, {128, 128, 128});
  EXPECT_EQ(objects.publish("statue", grid).chunks, 8u);
  const Knowledge late(*reader);
  const auto here = late.object("statue", 2, 30s);
  ASSERT_NE(here, nullptr);
  EXPECT_TRUE(testing::same_voxels(*here->grid, grid));
}

INSTANTIATE_TEST_SUITE_P(, ObjectPublisherTest, dds::testing::each_vendor_pair(), dds::testing::pair_name);

}  // namespace
}  // namespace periplus::wire
