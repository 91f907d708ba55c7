#include "services/vision_server/rectification.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <utility>

namespace periplus::vision {
namespace {

const Pinhole kRawCamera = Pinhole::from_vertical_fov(160, 120, 0.5);

CapturedView ideal_view() {
  CapturedView v;
  v.left_calibration = CameraCalibration::ideal(kRawCamera);
  v.right_calibration = CameraCalibration::ideal(kRawCamera, 0.144);
  v.left = v.right = ImageU8(160, 120, 3);
  for (std::size_t i = 0; i < v.left.data.size(); ++i) v.left.data[i] = static_cast<std::uint8_t>(i * 7 % 251);
  return v;
}

RectifiedPair rectify(const CapturedView& v, const Pose& X_WC_raw) {
  RectificationMaps maps;
  return vision::rectify(v, X_WC_raw, maps);
}

TEST(Rectification, IdealImagesPassUntouched) {
  const CapturedView v = ideal_view();
  const Pose X_WC = look_at({0, 0, 1}, {1, 0, 1});
  const RectifiedPair pair = rectify(v, X_WC);
  EXPECT_EQ(pair.left.data, v.left.data);
  EXPECT_EQ(pair.left_grey.channels, 1);
  EXPECT_NEAR(pair.rig.baseline, 0.144, 1e-12);
  EXPECT_EQ(pair.rig.camera.fx, kRawCamera.fx);
  EXPECT_TRUE(pair.X_WC.isApprox(X_WC));
}

TEST(Rectification, ATurnedCameraIsTurnedBack) {
  // The raw camera looks 1 degree to the right of the rectified one: R turns raw into rectified coordinates.
  CapturedView v = ideal_view();
  const double angle = 0.0175;
  v.left_calibration.R = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
  // A white column where the direction 0.05 rad right of the rectified axis falls in the raw image.
  v.left = ImageU8(160, 120, 3, 0);
  const double u_raw = kRawCamera.cx + kRawCamera.fx * std::tan(0.05 - angle);
  for (int y = 0; y < 120; ++y)
    for (int c = 0; c < 3; ++c) v.left.at(static_cast<int>(std::lround(u_raw)), y, c) = 255;
  const RectifiedPair pair = rectify(v, Pose::Identity());
  const double u = kRawCamera.cx + kRawCamera.fx * std::tan(0.05);
  double weight = 0, sum = 0;
  for (int x = 0; x < 160; ++x) {
    weight += pair.left_grey.at(x, 60);
    sum += x * pair.left_grey.at(x, 60);
  }
  ASSERT_GT(weight, 0);
  EXPECT_NEAR(sum / weight, u, 0.6);
  // A point on the rectified axis lies `angle` to the left of the raw one.
  const Eigen::Vector3d axis = pair.X_WC.linear() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(axis.x(), -std::sin(angle), 1e-9);
}

TEST(Rectification, RadialDistortionIsUndone) {
  CapturedView v = ideal_view();
  v.left_calibration.distortion = {0.3, 0, 0, 0, 0};
  v.left = ImageU8(160, 120, 1, 0);
  const double r = 0.2, u_raw = kRawCamera.cx + kRawCamera.fx * r * (1 + 0.3 * r * r);
  for (int y = 0; y < 120; ++y) v.left.at(static_cast<int>(std::lround(u_raw)), y) = 255;
  v.right = ImageU8(160, 120, 1);
  const RectifiedPair pair = rectify(v, Pose::Identity());
  EXPECT_EQ(pair.left.channels, 3);
  double weight = 0, sum = 0;
  for (int x = 0; x < 160; ++x) {
    weight += pair.left_grey.at(x, 60);
    sum += x * pair.left_grey.at(x, 60);
  }
  ASSERT_GT(weight, 0);
  EXPECT_NEAR(sum / weight, kRawCamera.cx + kRawCamera.fx * r, 0.7);
}

TEST(Rectification, MapsAreComputedOncePerCalibrationAndGiveTheSamePixels) {
  CapturedView v = ideal_view();
  v.left_calibration.distortion = {0.3, -0.1, 0.001, 0, 0};
  v.right_calibration.distortion = {0.2, 0, 0, 0.001, 0};
  RectificationMaps maps(2);
  const RectifiedPair first = vision::rectify(v, Pose::Identity(), maps);
  EXPECT_EQ(maps.computed(), 2u);
  for (int i = 0; i < 3; ++i) {
    const RectifiedPair again = vision::rectify(v, Pose::Identity(), maps);
    EXPECT_EQ(again.left.data, first.left.data);
    EXPECT_EQ(again.right.data, first.right.data);
  }
  EXPECT_EQ(maps.computed(), 2u);

  // Another number, another map: the images are those of a cache that never saw the first.
  CapturedView other = v;
  other.left_calibration.distortion[0] = 0.1;
  EXPECT_EQ(vision::rectify(other, Pose::Identity(), maps).left.data, rectify(other, Pose::Identity()).left.data);
  EXPECT_EQ(maps.computed(), 3u);
  other.left_calibration.R = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_EQ(vision::rectify(other, Pose::Identity(), maps).left.data, rectify(other, Pose::Identity()).left.data);
  EXPECT_EQ(maps.computed(), 4u);
  // Only two are kept: the first pair's have left.
  vision::rectify(v, Pose::Identity(), maps);
  EXPECT_EQ(maps.computed(), 5u);

  // Ideal images need none, and another size is another calibration.
  RectificationMaps fresh;
  vision::rectify(ideal_view(), Pose::Identity(), fresh);
  EXPECT_EQ(fresh.computed(), 0u);
  for (const int factor : {1, 2, 4}) {
    CameraCalibration c = CameraCalibration::ideal(Pinhole::from_vertical_fov(160 * factor, 120 * factor, 0.5));
    c.distortion = {0.3, 0, 0, 0, 0};
    for (int i = 0; i < 2; ++i) {
      const ImageU8 out = fresh.resample(ImageU8(c.width, c.height, 3, 77), c);
      EXPECT_EQ(out.width, c.width);
      EXPECT_EQ(out.height, c.height);
      EXPECT_EQ(out.at(c.width / 2, c.height / 2, 1), 77);
    }
  }
  EXPECT_EQ(fresh.computed(), 3u);
}

TEST(Rectification, RefusesWhatIsNoRectifiedPair) {
  const auto code = [](const CapturedView& v) {
    try {
      rectify(v, Pose::Identity());
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  };
  CapturedView v = ideal_view();
  EXPECT_EQ(code(v), ErrorCode::ok);
  v.right_calibration.P(0, 3) = 0;
  EXPECT_EQ(code(v), ErrorCode::vision_image_bad);
  v = ideal_view();
  v.right_calibration.P(1, 2) += 3;
  EXPECT_EQ(code(v), ErrorCode::vision_image_bad);
  v = ideal_view();
  std::swap(v.left_calibration, v.right_calibration);
  EXPECT_EQ(code(v), ErrorCode::vision_image_bad);
  for (const auto& [row, column, value] : {std::tuple(2, 2, 0.0), std::tuple(0, 1, 4.0), std::tuple(2, 0, 0.1)}) {
    v = ideal_view();
    v.left_calibration.P(row, column) = v.right_calibration.P(row, column) = value;
    EXPECT_EQ(code(v), ErrorCode::vision_image_bad) << row << column;
  }
  v = ideal_view();
  v.right = ImageU8(80, 60, 3);
  EXPECT_EQ(code(v), ErrorCode::vision_image_bad);
  v = ideal_view();
  v.right_calibration.width = 80;
  EXPECT_EQ(code(v), ErrorCode::vision_image_bad);
}

}  // namespace
}  // namespace periplus::vision
