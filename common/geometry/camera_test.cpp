#include "common/geometry/camera.h"

#include <gtest/gtest.h>

#include <limits>

#include <numbers>

#include "common/core/error.h"

namespace periplus {
namespace {

TEST(Pinhole, FocalLengthOfTheRobotsEyes) {
  // FINDINGS: 25 degrees vertical at 640x480 is f = 1082 px; 144 mm baseline gives 156/z px.
  const Pinhole c = Pinhole::from_vertical_fov(640, 480, 25 * std::numbers::pi / 180);
  EXPECT_NEAR(c.fx, 1082, 1);
  const StereoRig rig{c, 0.144};
  EXPECT_NEAR(rig.disparity(1.0), 156, 0.5);
  EXPECT_NEAR(rig.depth(rig.disparity(1.3)), 1.3, 1e-12);
  EXPECT_NEAR(c.vertical_fov(), 25 * std::numbers::pi / 180, 1e-12);
}

TEST(Pinhole, BackProjectInvertsProject) {
  const Pinhole c = Pinhole::from_vertical_fov(640, 480, 0.5);
  const Eigen::Vector3d p(0.1, -0.2, 1.3);
  const Eigen::Vector2d uv = c.project(p);
  EXPECT_TRUE(c.back_project(uv.x(), uv.y(), 1.3).isApprox(p, 1e-12));
}

TEST(Pinhole, RefusesNonsense) {
  EXPECT_THROW(Pinhole::from_vertical_fov(640, 480, 0), Error);
  EXPECT_THROW(Pinhole::from_vertical_fov(0, 480, 0.5), Error);
  StereoRig rig{Pinhole::from_vertical_fov(640, 480, 0.5), -1};
  EXPECT_THROW(rig.check(), Error);
}

TEST(Pinhole, RefusesFocalLengthsThatNoLensHas) {
  const Pinhole good = Pinhole::from_vertical_fov(640, 480, 0.5);
  good.check();
  for (const double f : {0.0, -1.0, 1e-9, 2e6, 1e300, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    Pinhole bad = good;
    bad.fx = f;
    EXPECT_THROW(bad.check(), Error) << f;
    bad = good;
    bad.fy = f;
    EXPECT_THROW(bad.check(), Error) << f;
  }
}

}  // namespace
}  // namespace periplus
