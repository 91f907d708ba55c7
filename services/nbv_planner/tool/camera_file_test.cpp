#include "services/nbv_planner/tool/camera_file.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/core/error.h"

namespace periplus::nbv {
namespace {

constexpr double kDeg = std::numbers::pi / 180;

std::string refusal(const std::string& yaml) {
  try {
    parse_camera(yaml, "camera.yaml");
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input) << e.what();
    return e.what();
  }
  return "";
}

TEST(CameraFile, EveryKeyIsTaken) {
  const CameraFile c = parse_camera(
      "schema: periplus-camera-1\nname: pair\nresolution_px: [640, 480]\nfocal_px: [500, 510]\ncenter_px: [310, 250]\n"
      "baseline_m: 0.1\nmeasures_m: [0.4, 3]\nhead_radius_m: 0.2\n"
      "limits: {height_m: [0.3, 2], distance_m: [0.5, 3], pitch_deg: [-30, 60], roll_deg: 5, yaw_deg: [0, 90]}\n"
      "body: {lower_m: [-0.2, -0.4, 0], upper_m: [0.2, 0.4, 1.5]}\nscene: room.yaml\n",
      "camera.yaml");
  EXPECT_EQ(c.name, "pair");
  EXPECT_EQ(c.rig.camera.width, 640);
  EXPECT_EQ(c.rig.camera.fx, 500);
  EXPECT_EQ(c.rig.camera.fy, 510);
  EXPECT_EQ(c.rig.camera.cx, 310);
  EXPECT_EQ(c.rig.camera.cy, 250);
  EXPECT_EQ(c.rig.baseline, 0.1);
  EXPECT_EQ(c.measures, Eigen::Vector2d(0.4, 3));
  EXPECT_EQ(c.head_radius, 0.2);
  EXPECT_EQ(c.limits.height_max, 2);
  EXPECT_EQ(c.limits.distance_min, 0.5);
  EXPECT_NEAR(c.limits.pitch_min, -30 * kDeg, 1e-15);
  EXPECT_NEAR(c.limits.roll_max, 5 * kDeg, 1e-15);
  EXPECT_NEAR(c.limits.yaw_max, 90 * kDeg, 1e-15);
  EXPECT_EQ(c.body->upper.z(), 1.5);
  EXPECT_EQ(c.scene, "room.yaml");
}

TEST(CameraFile, FieldsOfViewAreThoseAsked) {
  const CameraFile wide = parse_camera("resolution_px: [640, 480]\nhorizontal_fov_deg: 60\n", "hand.yaml");
  EXPECT_NEAR(wide.rig.camera.horizontal_fov(), 60 * kDeg, 1e-12);
  EXPECT_EQ(wide.rig.baseline, 0);
  EXPECT_EQ(wide.name, "hand");
  EXPECT_FALSE(wide.body || wide.measures || wide.head_radius);
  EXPECT_NEAR(parse_camera("resolution_px: [640, 480]\nvertical_fov_deg: 25\n", "c").rig.camera.vertical_fov(), 25 * kDeg, 1e-12);
}

TEST(CameraFile, SaysWhatIsWrongAndWhere) {
  const std::string start = "resolution_px: [640, 480]\nhorizontal_fov_deg: 60\n";
  EXPECT_NE(refusal("horizontal_fov_deg: 60\n").find("resolution_px"), std::string::npos);
  EXPECT_NE(refusal("resolution_px: [640, 480]\n").find("exactly one of"), std::string::npos);
  EXPECT_NE(refusal(start + "vertical_fov_deg: 40\n").find("exactly one of"), std::string::npos);
  EXPECT_NE(refusal("resolution_px: [640.5, 480]\nhorizontal_fov_deg: 60\n").find("whole numbers"), std::string::npos);
  EXPECT_NE(refusal(start + "basline_m: 0.1\n").find("baseline_m"), std::string::npos);  // names the nearest
  EXPECT_NE(refusal(start + "limits: {height_m: [2, 1]}\n").find("least < greatest"), std::string::npos);
  EXPECT_NE(refusal(start + "limits: {height_m: [.nan, 1]}\n").find("height_m"), std::string::npos);
  EXPECT_NE(refusal(start + "limits: {hight_m: [1, 2]}\n").find("camera.yaml:3"), std::string::npos);
  EXPECT_NE(refusal(start + "measures_m: [2, 1]\n").find("measures_m"), std::string::npos);
  EXPECT_NE(refusal(start + "center_px: [1, 2]\n").find("focal_px"), std::string::npos);
  EXPECT_NE(refusal(start + "body: {lower_m: [0, 0, 0], upper_m: [1, 0, 1]}\n").find("lower_m"), std::string::npos);
  EXPECT_NE(refusal(start + "schema: periplus-robot-1\n").find("periplus-camera-1"), std::string::npos);
  EXPECT_NE(refusal("resolution_px: [640, 480\n").find("camera.yaml"), std::string::npos);
}

}  // namespace
}  // namespace periplus::nbv
