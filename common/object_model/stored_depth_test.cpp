#include "common/object_model/stored_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/core/random.h"

namespace periplus::object_model {
namespace {

TEST(StoredDepth, IsWithinHalfAUnitAndItsMinimumNeverGrows) {
  Random random(3);
  DepthMap map;
  map.camera = Pinhole::from_vertical_fov(64, 48, 0.4);
  map.X_WC = look_at({1, 2, 0.5}, {0, 0, 1});
  map.depth = map.depth_minimum = ImageF(64, 48);
  for (std::size_t i = 0; i < map.depth.data.size(); ++i) {
    if (i % 5 == 0) continue;  // none
    map.depth.data[i] = static_cast<float>(random.uniform(0.3, 8));
    map.depth_minimum.data[i] = map.depth.data[i] - static_cast<float>(random.uniform(0, 0.1));
  }
  const Pose X_WC = look_at({1.1, 2, 0.5}, {0, 0, 1});
  const StoredDepth stored = store_depth(map, X_WC);
  const DepthMap back = restore_depth(stored, X_WC);
  EXPECT_TRUE(back.X_WC.isApprox(map.X_WC, 1e-12));
  int far = 0;
  for (std::size_t i = 0; i < map.depth.data.size(); ++i) {
    const float z = map.depth.data[i];
    if (z > 6.5535f) {
      EXPECT_FLOAT_EQ(back.depth.data[i], 6.5535f);
      ++far;
    } else {
      EXPECT_NEAR(back.depth.data[i], z, 0.51e-4);  // in single precision besides
    }
    EXPECT_LE(back.depth_minimum.data[i], map.depth_minimum.data[i] + 1e-6f);
    EXPECT_LE(back.depth_minimum.data[i], back.depth.data[i]);
    EXPECT_GT(back.depth_minimum.data[i], std::min(map.depth_minimum.data[i], 6.5535f) - 1.01e-4f);
  }
  EXPECT_GT(far, 100);
  // Once stored it stays as it is.
  const StoredDepth again = store_depth(back, X_WC);
  EXPECT_EQ(again.depth.data, stored.depth.data);
}

TEST(StoredDepth, KeepsTheStandardDeviationAsItGrowsWithDepth) {
  Random random(4);
  DepthMap map;
  map.camera = Pinhole::from_vertical_fov(64, 48, 0.4);
  map.depth = map.depth_minimum = map.depth_sigma = ImageF(64, 48);
  EXPECT_TRUE(restore_depth(store_depth(map, Pose::Identity()), Pose::Identity()).depth_sigma.empty());  // exact
  for (std::size_t i = 0; i < map.depth.data.size(); ++i) {
    const auto z = static_cast<float>(i % 5 == 0 ? 0 : random.uniform(0.3, 6));
    map.depth.data[i] = z;
    map.depth_sigma.data[i] = 0.0016f * z * z;
  }
  const StoredDepth stored = store_depth(map, Pose::Identity());
  const DepthMap back = restore_depth(stored, Pose::Identity());
  for (std::size_t i = 0; i < map.depth.data.size(); ++i) EXPECT_NEAR(back.depth_sigma.data[i], map.depth_sigma.data[i], 3e-6f);
  // A few pixels do not speak for all: one close to the camera, others beyond belief.
  map.depth.at(1, 0) = map.depth_minimum.at(1, 0) = 0.01f;
  map.depth_sigma.at(1, 0) = 0.01f;
  map.depth_sigma.at(2, 0) = std::numeric_limits<float>::infinity();
  map.depth_sigma.at(3, 0) = std::numeric_limits<float>::quiet_NaN();
  map.depth.at(4, 0) = map.depth_minimum.at(4, 0) = std::numeric_limits<float>::denorm_min();
  EXPECT_NEAR(store_depth(map, Pose::Identity()).sigma_per_z2, 0.0016, 1e-8);
}

TEST(StoredDepth, TakesNoStandardDeviationsForNoneAndHasAMost) {
  DepthMap map;
  map.camera = Pinhole::from_vertical_fov(8, 6, 0.4);
  map.depth = map.depth_minimum = ImageF(8, 6, 1, 2.0f);
  const auto stored = [&](float sigma) {
    map.depth_sigma = ImageF(8, 6, 1, sigma);
    return store_depth(map, Pose::Identity()).sigma_per_z2;
  };
  EXPECT_EQ(stored(-1), 0);
  EXPECT_EQ(stored(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(stored(std::numeric_limits<float>::infinity()), 1);
  map.depth = map.depth_minimum = ImageF(8, 6);
  EXPECT_EQ(stored(0.1f), 0);  // of no depth
}

TEST(StoredDepth, CarvesNothingWhereNoMinimumWasKept) {
  StoredDepth stored;
  stored.camera = Pinhole::from_vertical_fov(8, 6, 0.4);
  stored.depth = Image<std::uint16_t>(8, 6, 1, 12000);
  const DepthMap map = restore_depth(stored, Pose::Identity());
  EXPECT_FLOAT_EQ(map.depth.at(3, 3), 1.2f);
  EXPECT_EQ(map.depth_minimum.data, ImageF(8, 6).data);
}

}  // namespace
}  // namespace periplus::object_model
