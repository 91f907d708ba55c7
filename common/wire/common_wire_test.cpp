#include "common/wire/common_wire.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::wire {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

template <class Function>
ErrorCode code_of(Function&& function) {
  try {
    function();
  } catch (const Error& e) {
    return e.code();
  }
  return ErrorCode::ok;
}

TEST(CommonWire, PosesComeBack) {
  Random random(2);
  for (int n = 0; n < 100; ++n) {
    const Pose X = make_pose({random.normal(), random.normal(), random.normal()},
                             rotation_from_yaw_pitch_roll(random.uniform(-3, 3), random.uniform(-1.5, 1.5), random.uniform(-3, 3)));
    EXPECT_TRUE(from_wire(to_wire(X)).isApprox(X, 1e-12));
  }
  const Pose2 floor = from_wire(to_wire(Pose2{1, -2, 0.3}));
  EXPECT_EQ(floor.x, 1);
  EXPECT_EQ(floor.y, -2);
  EXPECT_EQ(floor.yaw, 0.3);
}

TEST(CommonWire, HostilePosesAreRefused) {
  msg::Pose m = to_wire(Pose::Identity());
  m.qw(0.5);
  EXPECT_EQ(code_of([&] { from_wire(m); }), ErrorCode::bad_input);
  m.qw(kNan);
  EXPECT_EQ(code_of([&] { from_wire(m); }), ErrorCode::not_finite);
  m = to_wire(Pose::Identity());
  m.qw(1.0005);
  EXPECT_TRUE(from_wire(m).isApprox(Pose::Identity(), 1e-12));  // small errors of length are mended
  m.position().y(std::numeric_limits<double>::infinity());
  EXPECT_EQ(code_of([&] { from_wire(m); }), ErrorCode::not_finite);
  msg::Pose2 floor = to_wire(Pose2{});
  floor.yaw(kNan);
  EXPECT_EQ(code_of([&] { from_wire(floor); }), ErrorCode::not_finite);
}

TEST(CommonWire, CamerasComeBackAndAreChecked) {
  const StereoRig rig{Pinhole::from_vertical_fov(640, 480, 0.436), 0.144};
  msg::StereoRig m = to_wire(rig);
  const StereoRig back = from_wire(m);
  EXPECT_EQ(back.camera.width, 640);
  EXPECT_EQ(back.camera.fx, rig.camera.fx);
  EXPECT_EQ(back.camera.cy, rig.camera.cy);
  EXPECT_EQ(back.baseline, 0.144);
  m.camera().width(4000000000u);
  EXPECT_EQ(code_of([&] { from_wire(m); }), ErrorCode::bad_input);
  m = to_wire(rig);
  m.camera().fx(0);
  EXPECT_EQ(code_of([&] { from_wire(m); }), ErrorCode::bad_input);
  m = to_wire(rig);
  m.baseline(kNan);
  EXPECT_EQ(code_of([&] { from_wire(m); }), ErrorCode::not_finite);
}

TEST(CommonWire, BoxesNeedPositiveSidesOfSaneLength) {
  object_model::ObjectBox box;
  box.size = {0.5, 0.6, 0.7};
  EXPECT_EQ(from_wire(to_wire(box)).size, box.size);
  for (const double bad : {0.0, -1.0, 21.0}) {
    box.size.y() = bad;
    EXPECT_EQ(code_of([&] { from_wire(to_wire(box)); }), ErrorCode::bad_input);
  }
}

TEST(CommonWire, IdentifiersAreOfPlainCharacters) {
  for (const char* good : {"a", "view-1", "A_b.9", "0"}) EXPECT_NO_THROW(check_id(good, "id"));
  for (const char* bad : {"", ".", "..", "a/b", "a b", "\xc3\xa9", "a\n"}) EXPECT_THROW(check_id(bad, "id"), Error);
  EXPECT_NO_THROW(check_id(std::string(64, 'x'), "id"));
  EXPECT_THROW(check_id(std::string(65, 'x'), "id"), Error);
  EXPECT_EQ(id_from_wire(msg::Id(""), "id", true), "");
  EXPECT_THROW(id_from_wire(msg::Id(""), "id"), Error);
}

TEST(CommonWire, TextsAndVectors) {
  EXPECT_EQ(text_from_wire(text_to_wire("\xc3\xa9t\xc3\xa9")), "\xc3\xa9t\xc3\xa9");
  EXPECT_EQ(vector_from_wire({1, 2, 3}, "v", 3), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(code_of([] { vector_from_wire({1, 2}, "v", 3); }), ErrorCode::bad_size);
  EXPECT_EQ(code_of([] { vector_from_wire({1, kNan}, "v"); }), ErrorCode::not_finite);
  EXPECT_EQ(vector_to_wire(Eigen::Vector2d(4, 5)), (std::vector<double>{4, 5}));
  const msg::NamedNumber n = named("gain", 2.5);
  EXPECT_EQ(n.name().to_string(), "gain");
  EXPECT_EQ(n.value(), 2.5);
}

}  // namespace
}  // namespace periplus::wire
