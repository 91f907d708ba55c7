#include "common/wire/object_wire.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "common/core/error.h"
#include "common/wire/testing/environment_texts.h"

namespace periplus::wire {
namespace {

TEST(ObjectWire, CountsComeBack) {
  const voxel::Counts c{1, 2, 3, 4};
  EXPECT_EQ(from_wire(to_wire(c)), c);
}

TEST(ObjectWire, EnvironmentsAreParsedAndTheirRevisionChecked) {
  const auto t = testing::environment_texts();
  const msg::Environment m = environment_to_wire("room", t.scene_yaml, t.robot_yaml, t.robot_urdf);
  const KnownEnvironment e = environment_from_wire(m);
  EXPECT_EQ(e.scene_id, "room");
  EXPECT_EQ(e.revision.size(), 64u);
  EXPECT_EQ(e.revision, m.revision().to_string());
  ASSERT_NE(e.robot, nullptr);
  EXPECT_EQ(e.scene.solids.size(), 1u);
  EXPECT_TRUE(e.collision->contains({0, 0, 0.3}));

  msg::Environment bad = m;
  bad.revision("0000");
  EXPECT_THROW(environment_from_wire(bad), Error);
  bad.revision("");
  EXPECT_EQ(environment_from_wire(bad).revision, e.revision);
  bad.scene_yaml(std::vector<std::uint8_t>{'{'});
  EXPECT_THROW(environment_from_wire(bad), Error);
  bad = m;
  bad.robot_urdf().clear();
  bad.revision("");
  EXPECT_THROW(environment_from_wire(bad), Error);
}

TEST(ObjectWire, TheRevisionSeparatesTheTexts) {
  EXPECT_NE(environment_revision("ab", "c", "d"), environment_revision("a", "bc", "d"));
  EXPECT_EQ(environment_revision("a", "b", "c"), environment_revision("a", "b", "c"));
}

}  // namespace
}  // namespace periplus::wire
