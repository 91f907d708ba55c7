#include "common/render/world_builder.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace periplus::render {
namespace {

int count(const std::string& text, const std::string& what) {
  int n = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(WorldBuilder, EqualTexturesAreMadeOnce) {
  scene::Scene s = scene::parse_scene(R"(
name: test
room: {size_m: [4, 4, 2.5]}
solids:
  - {name: a, size_m: [1, 1, 1], position_m: [0, 0, 0.5], texture: "noise:3"}
  - {name: b, size_m: [1, 1, 1], position_m: [1.5, 0, 0.5], texture: "noise:3"}
  - {name: c, size_m: [1, 1, 1], position_m: [0, 1.5, 0.5], rgb: [1, 0, 0]}
lights: [{position_m: [0, 0, 2]}, {position_m: [1, 0, 2]}]
)",
                                      "test");
  const World w = build_world(s, {}, {});
  EXPECT_EQ(w.textures.size(), 1u);
  EXPECT_EQ(w.meshes.size(), 3u);
  EXPECT_EQ(count(w.xml, "<light"), 2);
  EXPECT_EQ(count(w.xml, "type='plane'"), 5);
  EXPECT_NE(w.xml.find("rgba='1 0 0 1'"), std::string::npos);
  s.room.wall_texture = "noise:3";
  const World textured = build_world(s, {}, {});
  ASSERT_EQ(textured.textures.size(), 5u);  // four walls of their own
  EXPECT_NE(textured.textures[0].second.data, textured.textures[1].second.data);
}

}  // namespace
}  // namespace periplus::render
