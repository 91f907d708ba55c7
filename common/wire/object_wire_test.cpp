#include "common/wire/object_wire.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <vector>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/dds/codec_impl.h"
#include "common/wire/testing/environment_texts.h"

namespace periplus::wire {
namespace {

std::vector<Pose> sample_views(int n) {
  std::vector<Pose> views;
  for (int i = 0; i < n; ++i) views.push_back(look_at({std::cos(0.01 * i), std::sin(0.01 * i), 1.2}, {0, 0, 0.7}));
  return views;
}

msg::ObjectGrid sample_grid() {
  voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(make_pose({1, 2, 3}, rotation_from_yaw_pitch_roll(0.3, 0, 0)), {0.2, 0.13, 0.1}, 0.01));
  grid.revision = 7;
  Random random(4);
  for (int n = 0; n < 500; ++n)
    grid.set_state({static_cast<int>(random.below(20)), static_cast<int>(random.below(13)), static_cast<int>(random.below(10))},
                   static_cast<voxel::VoxelState>(random.below(4)));
  return object_to_wire("bunny", grid, {{{1, 2, 3}, {0, 0, 1}, 0.02}, {{4, 5, 6}, {1, 0, 0}, 0.03}}, sample_views(3));
}

template <class Change>
ErrorCode grid_refusal(Change&& change) {
  msg::ObjectGrid m = sample_grid();
  change(m);
  try {
    object_from_wire(m);
  } catch (const Error& e) {
    return e.code();
  }
  return ErrorCode::ok;
}

TEST(ObjectWire, GridsComeBack) {
  const msg::ObjectGrid m = sample_grid();
  const KnownObject o = object_from_wire(m);
  EXPECT_EQ(o.object_id, "bunny");
  EXPECT_EQ(o.revision, 7u);
  EXPECT_EQ(o.grid->revision, 7u);
  EXPECT_EQ(o.grid->geometry().size, Eigen::Vector3i(20, 13, 10));
  ASSERT_EQ(o.landmarks.size(), 2u);
  EXPECT_EQ(o.landmarks[1].p_W, Eigen::Vector3d(4, 5, 6));
  EXPECT_NEAR(o.landmarks[1].size_m, 0.03, 1e-8);
  ASSERT_EQ(o.views.size(), 3u);
  for (std::size_t n = 0; n < 3; ++n) EXPECT_TRUE(o.views[n].isApprox(sample_views(3)[n], 1e-14)) << n;
  const msg::ObjectGrid again = object_to_wire(o.object_id, *o.grid, o.landmarks, o.views);
  EXPECT_EQ(again.occupied(), m.occupied());
  EXPECT_EQ(again.known(), m.known());
  EXPECT_EQ(again.environment(), m.environment());
  EXPECT_GT(o.grid->counts().known, 0u);
}

TEST(ObjectWire, HostileGridsAreRefused) {
  using M = msg::ObjectGrid;
  EXPECT_EQ(grid_refusal([](M&) {}), ErrorCode::ok);
  EXPECT_EQ(grid_refusal([](M& m) { m.nx(4000000000u); }), ErrorCode::bad_size);
  EXPECT_EQ(grid_refusal([](M& m) { m.nx(0); }), ErrorCode::bad_input);
  EXPECT_EQ(grid_refusal([](M& m) { m.ny(512); }), ErrorCode::bad_size);
  EXPECT_EQ(grid_refusal([](M& m) { m.known().pop_back(); }), ErrorCode::bad_size);
  EXPECT_EQ(grid_refusal([](M& m) { m.occupied().clear(); }), ErrorCode::bad_size);
  EXPECT_EQ(grid_refusal([](M& m) { m.voxel_m(std::numeric_limits<double>::quiet_NaN()); }), ErrorCode::bad_input);
  EXPECT_EQ(grid_refusal([](M& m) { m.voxel_m(-0.01); }), ErrorCode::bad_input);
  EXPECT_EQ(grid_refusal([](M& m) { m.object_id("../etc"); }), ErrorCode::bad_input);
  EXPECT_EQ(grid_refusal([](M& m) { m.pose_world_grid().qx(3); }), ErrorCode::bad_input);
  EXPECT_EQ(grid_refusal([](M& m) { m.views()[1].position().z(std::numeric_limits<double>::infinity()); }), ErrorCode::not_finite);
  EXPECT_EQ(grid_refusal([](M& m) { m.views()[2].qy(std::numeric_limits<double>::quiet_NaN()); }), ErrorCode::not_finite);
  EXPECT_EQ(grid_refusal([](M& m) { m.views()[0].qw(2); }), ErrorCode::bad_input);
  EXPECT_EQ(grid_refusal([](M& m) { m.views().resize(kViewsOnWire, m.views()[0]); }), ErrorCode::ok);
  EXPECT_EQ(grid_refusal([](M& m) { m.views().resize(kViewsOnWire + 1, m.views()[0]); }), ErrorCode::bad_size);
  EXPECT_EQ(grid_refusal([](M& m) { m.landmarks()[0].size_m(std::numeric_limits<float>::infinity()); }), ErrorCode::not_finite);
  EXPECT_EQ(grid_refusal([](M& m) { m.landmarks()[0].normal().z(std::numeric_limits<double>::quiet_NaN()); }), ErrorCode::not_finite);
}

TEST(ObjectWire, TheLastViewsGoOut) {
  const std::vector<Pose> views = sample_views(kViewsOnWire + 5);
  const KnownObject o = object_from_wire(object_to_wire("bunny", voxel::OccupancyGrid(voxel::GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, 0.01)), {}, views));
  ASSERT_EQ(o.views.size(), kViewsOnWire);
  EXPECT_TRUE(o.views.front().isApprox(views[5], 1e-14));
  EXPECT_TRUE(o.views.back().isApprox(views.back(), 1e-14));
}

TEST(ObjectWire, BitsBeyondTheGridAndContradictionsAreCleared) {
  msg::ObjectGrid m = sample_grid();
  for (auto* plane : {&m.occupied(), &m.known(), &m.environment()}) std::fill(plane->begin(), plane->end(), 0xff);
  const auto counts = object_from_wire(m).grid->counts();
  EXPECT_EQ(counts, (voxel::Counts{0, 0, 0, 20 * 13 * 10}));
}

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
