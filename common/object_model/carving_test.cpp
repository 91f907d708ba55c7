#include "common/object_model/carving.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/object_model/evidence.h"
#include "common/object_model/testing/naive_carving.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/scene/scene.h"

namespace periplus::object_model {
namespace {

using namespace testing;

const CarvingSettings kSettings;

TEST(Carving, AgreesWithTheNaiveAlgorithmOnRandomDepths) {
  Random random(3);
  const Pinhole camera = Pinhole::from_vertical_fov(160, 120, 0.5);
  int emptied = 0, standing = 0, left_standing = 0;
  for (int round = 0; round < 6; ++round) {
    const Pose X_WB = make_pose({0, 0, 1}, rotation_from_yaw_pitch_roll(random.uniform(-3, 3), random.uniform(-0.5, 0.5), 0));
    const voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(X_WB, {0.31, 0.22, 0.27}, round % 2 ? 0.02 : 0.013));
    const Pose X_WC = look_at({random.uniform(0.5, 0.9), random.uniform(-0.6, 0.6), random.uniform(0.6, 1.4)}, {0, 0, 1});
    // Blocks of depth, some without any, so that whole projections may agree.
    ImageF limit(160, 120);
    for (int y = 0; y < 120; y += 20)
      for (int x = 0; x < 160; x += 20) {
        const float z = random.uniform() < 0.1 ? 0.0f : static_cast<float>(random.uniform(0.4, 2));
        for (int dy = 0; dy < 20; ++dy)
          for (int dx = 0; dx < 20; ++dx) limit.at(x + dx, y + dy) = z;
      }
    const auto plane = seen_through(grid, camera, X_WC, limit, 0.87);
    for (const voxel::Simd simd : {voxel::Simd::portable, voxel::Simd::avx2, voxel::Simd::avx512, voxel::Simd::avx512_popcnt}) {
      if (voxel::has_simd(simd)) {
        EXPECT_EQ(seen_through(grid, camera, X_WC, limit, 0.87, simd), plane) << voxel::to_string(simd);
      }
    }
    for_each_voxel(grid.geometry(), [&](const Eigen::Vector3i& v) {
      const bool expected = naive_empty(grid.geometry(), v, camera, X_WC, limit, 0.87);
      ++(expected ? emptied : standing);
      if (in_plane(grid, plane, v) == expected) return;
      EXPECT_TRUE(expected) << "emptied against Algorithm 3: " << v.transpose();
      ++left_standing;
    });
  }
  EXPECT_GT(emptied, 1000);
  EXPECT_GT(standing, 1000);
  EXPECT_LE(left_standing, emptied / 500);  // on a pixel's border to within rounding
}

// From within and beside the grid, close up and from afar, with every pixel size of a voxel: never more than Algorithm 3.
TEST(Carving, EmptiesNoMoreThanTheNaiveAlgorithmFromAnywhere) {
  Random random(4);
  int emptied = 0, left_standing = 0;
  for (int round = 0; round < 24; ++round) {
    const Pinhole camera = Pinhole::from_vertical_fov(200, 150, random.uniform(0.2, 1.6));
    const voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(make_pose({0, 0, 1}, rotation_from_yaw_pitch_roll(random.uniform(-3, 3), 0, 0)), {0.3, 0.3, 0.3}, 0.017));
    const double distance = round % 4 == 0 ? random.uniform(0.02, 0.2) : random.uniform(0.3, 4);
    const Pose X_WC = look_along({-distance, random.uniform(-0.1, 0.1), 1 + random.uniform(-0.1, 0.1)}, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.5, 0.5));
    ImageF limit(200, 150, 1, static_cast<float>(distance + random.uniform(-0.1, 0.3)));
    for (int k = 0; k < 6; ++k) limit.at(random.below(200), random.below(150)) = 0;
    const auto plane = seen_through(grid, camera, X_WC, limit, 0.87);
    for_each_voxel(grid.geometry(), [&](const Eigen::Vector3i& v) {
      const bool expected = naive_empty(grid.geometry(), v, camera, X_WC, limit, 0.87), found = in_plane(grid, plane, v);
      EXPECT_LE(found, expected) << v.transpose();
      emptied += expected;
      left_standing += expected && !found;
    });
  }
  EXPECT_GT(emptied, 5000);
  EXPECT_LE(left_standing, emptied / 500);
}

TEST(Carving, EmptiesNoVoxelThatTheSphereTouchesAndAllThatAreFarFromIt) {
  const Sphere sphere;
  const ObjectBox box = box_around(sphere);
  voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(box.X_WB, box.size, 0.01));
  Evidence evidence(grid.geometry());
  for (int n = 0; n < 8; ++n) {
    const Perception p = ideal_view(sphere, n, 8);
    for (const DepthMap& map : p.depth) {
      const PixelLimits limits = pixel_limits(map, grid.geometry(), kSettings, true, nullptr);
      empty_voxels(seen_through(grid, map.camera, map.X_WC, limits.limit, kSettings.margin_voxels), 1, grid, evidence);
    }
  }
  int touching = 0, far = 0, inside = 0;
  for_each_voxel(grid.geometry(), [&](const Eigen::Vector3i& v) {
    const auto [least, most] = distance_range(grid.geometry(), v, sphere);
    const voxel::VoxelState s = grid.state(v);
    if (most < sphere.radius || touches(grid.geometry(), v, sphere)) {
      EXPECT_NE(s, voxel::VoxelState::empty) << v.transpose();
      ++(most < sphere.radius ? inside : touching);
    } else if (least > sphere.radius + 0.05 && (grid.geometry().center_world(v) - sphere.center).head<2>().norm() < 0.2 &&
               std::abs(v.z() - 25) < 8) {  // within every image
      EXPECT_EQ(s, voxel::VoxelState::empty) << v.transpose();
      ++far;
    }
  });
  EXPECT_GT(touching, 2000);
  EXPECT_GT(inside, 5000);
  EXPECT_GT(far, 100);
}

TEST(Carving, EmptiesTheSpaceBeforeAWall) {
  const Pinhole camera = Pinhole::from_vertical_fov(320, 240, 0.5);
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({1, 0, 0}, Eigen::Matrix3d::Identity()), {0.2, 0.2, 0.2}, 0.01);
  const voxel::OccupancyGrid grid(g);
  const Pose X_WC = look_along({0, 0, 0}, 0, 0);
  const auto plane = seen_through(grid, camera, X_WC, ImageF(320, 240, 1, 1.0f), 0.87);
  for_each_voxel(g, [&](const Eigen::Vector3i& v) {
    // The wall stands at x = 1 m; voxels whose centre lies more than 0.87 voxels before it are empty, no others.
    EXPECT_EQ(in_plane(grid, plane, v), g.center_world(v).x() + 0.0087 < 1.0) << v.transpose();
  });
}

TEST(Carving, PixelsWithoutDepthNeverCarve) {
  const Sphere sphere;
  Perception p = ideal_view(sphere, 0, 4);
  DepthMap& map = p.depth[0];
  const ObjectBox box = box_around(sphere);
  const voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(box.X_WB, box.size, 0.01));
  // The left half of the image is blind.
  for (int y = 0; y < map.depth.height; ++y)
    for (int x = 0; x < map.depth.width / 2; ++x) map.depth.at(x, y) = 0;
  const PixelLimits limits = pixel_limits(map, grid.geometry(), kSettings, false, nullptr);
  const auto plane = seen_through(grid, map.camera, map.X_WC, limits.limit, kSettings.margin_voxels);
  const Pose X_CW = map.X_WC.inverse();
  int left = 0, right = 0;
  for_each_voxel(grid.geometry(), [&](const Eigen::Vector3i& v) {
    const bool blind = map.camera.project(X_CW * grid.geometry().center_world(v)).x() < map.depth.width / 2;
    if (in_plane(grid, plane, v)) ++(blind ? left : right);
  });
  EXPECT_EQ(left, 0);
  EXPECT_GT(right, 1000);
}

TEST(PixelLimits, OnlyNarrowGapsOfViewsThatAreNotCautiousClose) {
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({0, 0, 1}, Eigen::Matrix3d::Identity()), {0.2, 0.2, 0.2}, 0.01);
  DepthMap map;
  map.camera = Pinhole::from_vertical_fov(100, 80, 0.5);
  map.depth = ImageF(100, 80, 1, 2.0f);
  for (int y = 30; y < 36; ++y)
    for (int x = 30; x < 36; ++x) map.depth.at(x, y) = 0;
  for (int y = 30; y < 60; ++y)
    for (int x = 50; x < 80; ++x) map.depth.at(x, y) = 0;
  map.depth.at(29, 33) = 1.5f;
  map.depth_minimum = map.depth;
  const PixelLimits open = pixel_limits(map, g, kSettings, true, nullptr);
  EXPECT_FLOAT_EQ(open.limit.at(33, 33), 1.5f);  // the least of its four neighbours
  EXPECT_FLOAT_EQ(open.limit.at(33, 31), 2.0f);
  EXPECT_EQ(open.limit.at(65, 45), 0.0f);
  EXPECT_EQ(open.kind.at(33, 33), PixelKind::none);  // closed, not measured
  const PixelLimits cautious = pixel_limits(map, g, kSettings, false, nullptr);
  EXPECT_EQ(cautious.limit.at(33, 33), 0.0f);
}

// Pixel by pixel: up to the four nearest values.
TEST(PixelLimits, GapsCloseAsTheFourNearestNeighboursSay) {
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({0, 0, 1}, Eigen::Matrix3d::Identity()), {0.2, 0.2, 0.2}, 0.01);
  Random random(8);
  DepthMap map;
  map.camera = Pinhole::from_vertical_fov(90, 70, 0.5);
  int closed = 0, open = 0;
  for (const double share : {0.03, 0.3, 0.8, 0.97}) {
    map.depth = ImageF(90, 70);
    for (float& z : map.depth.data) z = random.uniform() < share ? 0.0f : static_cast<float>(random.uniform(1, 2));
    map.depth_minimum = map.depth;
    const PixelLimits limits = pixel_limits(map, g, kSettings, true, nullptr);
    for (int y = 0; y < 70; ++y)
      for (int x = 0; x < 90; ++x) {
        const auto neighbour = [&](int dx, int dy) {
          for (int n = 1; n <= kSettings.gap_px; ++n) {
            const int u = x + n * dx, v = y + n * dy;
            if (u < 0 || v < 0 || u >= 90 || v >= 70) break;
            if (map.depth.at(u, v) > 0) return map.depth.at(u, v);
          }
          return 0.0f;
        };
        float expected = map.depth.at(x, y);
        if (!(expected > 0)) {
          expected = std::min({neighbour(-1, 0), neighbour(1, 0), neighbour(0, -1), neighbour(0, 1)});
          ++(expected > 0 ? closed : open);
        }
        ASSERT_EQ(limits.limit.at(x, y), expected) << x << ", " << y << ", share " << share;
      }
  }
  EXPECT_GT(closed, 1000);
  EXPECT_GT(open, 1000);
}

TEST(CarvingRule, FollowsTheSilhouetteAndThePose) {
  const CarvingRule good = carving_rule(0.9, 0.001, 0.01, kSettings);
  EXPECT_TRUE(good.close_gaps);
  EXPECT_EQ(good.votes, 1);
  EXPECT_EQ(good.margin_voxels, kSettings.margin_voxels);
  const CarvingRule bare = carving_rule(0.7, 0.001, 0.01, kSettings);
  EXPECT_FALSE(bare.close_gaps);
  EXPECT_EQ(bare.votes, kSettings.cautious_votes);
  EXPECT_EQ(bare.margin_voxels, kSettings.margin_voxels);
  const CarvingRule lost = carving_rule(0.9, 0.0035, 0.01, kSettings);
  EXPECT_FALSE(lost.close_gaps);
  EXPECT_EQ(lost.votes, kSettings.cautious_votes);
  EXPECT_EQ(lost.margin_voxels, kSettings.uncertain_margin_voxels);
  EXPECT_EQ(carving_rule(0.9, 0.0035, 0.02, kSettings).votes, 1);   // little beside such voxels
  EXPECT_EQ(carving_rule(0.9, 0.0024, 0.001, kSettings).votes, 1);  // better than any pose is known
  EXPECT_EQ(carving_rule(0.9, std::nan(""), 0.01, kSettings).votes, kSettings.cautious_votes);
}

// Against a great many poses drawn from the covariance.
TEST(CarvingRule, SigmaOfAPointIsThatOfDrawnPoses) {
  Random random(5);
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance.diagonal() << 1e-6, 1e-6, 1e-6, 4e-6, 4e-6, 4e-6;
  const Eigen::Vector3d p(0, 0, 1.5);
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  constexpr int kDraws = 20000;
  for (int n = 0; n < kDraws; ++n) {
    const Eigen::Vector3d t(random.normal(), random.normal(), random.normal()), r(random.normal(), random.normal(), random.normal());
    const Eigen::Vector3d moved = 1e-3 * t + (2e-3 * r).cross(p);
    squares += moved.cwiseAbs2();
  }
  EXPECT_NEAR(point_sigma(covariance, 1.5), std::sqrt(squares.maxCoeff() / kDraws), 1e-4);
  covariance(0, 0) = 9e-6;
  EXPECT_NEAR(point_sigma(covariance, 0), 3e-3, 1e-9);
}

TEST(PixelLimits, KnownSolidsCarveFurtherButNotAcrossADepthEdge) {
  scene::Scene scene;
  scene::Solid table;
  table.name = "table";
  table.size = {2, 2, 0.7};
  table.X_WS.translation() = Eigen::Vector3d(0, 0, 0.35);
  scene.solids.push_back(table);
  const scene::CollisionWorld world(scene);
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({0, 0, 0.75}, Eigen::Matrix3d::Identity()), {0.2, 0.2, 0.2}, 0.01);
  DepthMap map;
  map.camera = Pinhole::from_vertical_fov(60, 60, 0.2);
  map.X_WC = look_at({0.001, 0, 1.7}, {0, 0, 0.7});  // straight down on the table, 1 m below
  map.depth = ImageF(60, 60, 1, 1.0f);
  map.depth_minimum = map.depth;
  map.depth_minimum.at(10, 10) = 0.9f;   // something stands there
  map.depth.at(20, 20) = map.depth_minimum.at(20, 20) = 0.95f;  // 5 cm over the table: the object
  const PixelLimits limits = pixel_limits(map, g, kSettings, true, &world);
  EXPECT_EQ(limits.kind.at(30, 30), PixelKind::known_solid);
  EXPECT_NEAR(limits.limit.at(30, 30), 1.015, 1e-6);
  EXPECT_NEAR(limits.limit.at(10, 10), 0.9, 1e-6);
  EXPECT_EQ(limits.kind.at(20, 20), PixelKind::surface);
  EXPECT_NEAR(limits.limit.at(20, 20), 0.95, 1e-6);
}

TEST(PixelLimits, TheFloorIsKnownToWithinTheDepthsUncertainty) {
  const scene::CollisionWorld world{scene::Scene{}};
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({0, 0, 0.2}, Eigen::Matrix3d::Identity()), {0.4, 0.4, 0.4}, 0.02);
  DepthMap map;
  map.camera = Pinhole::from_vertical_fov(60, 60, 0.1);
  map.X_WC = look_at({0.001, 0, 2.0}, {0, 0, 0});  // straight down, 2 m above
  map.depth = ImageF(60, 60, 1, 2.0f);
  map.depth.at(10, 10) = 1.99f;   // 1 cm over the floor: within 3 sigma
  map.depth.at(20, 20) = 1.97f;   // 3 cm: something lies there
  map.depth_minimum = map.depth;
  map.depth_sigma = ImageF(60, 60, 1, 0.008f);
  PixelLimits limits = pixel_limits(map, g, kSettings, true, &world);
  EXPECT_EQ(limits.kind.at(30, 30), PixelKind::known_solid);
  EXPECT_EQ(limits.kind.at(10, 10), PixelKind::known_solid);
  EXPECT_EQ(limits.kind.at(20, 20), PixelKind::surface);
  // Only what surely is the floor is carved into.
  EXPECT_NEAR(limits.limit.at(30, 30), 2.03, 1e-6);
  EXPECT_NEAR(limits.limit.at(10, 10), 1.99, 1e-6);
  map.depth_sigma = ImageF(60, 60, 1, 0.001f);
  EXPECT_EQ(pixel_limits(map, g, kSettings, true, &world).kind.at(10, 10), PixelKind::surface);
  // However uncertain a depth is, two voxels above the floor stand on it.
  map.depth.at(20, 20) = map.depth_minimum.at(20, 20) = 1.959f;
  map.depth_sigma = ImageF(60, 60, 1, 4.0f);
  limits = pixel_limits(map, g, kSettings, true, &world);
  EXPECT_EQ(limits.kind.at(10, 10), PixelKind::known_solid);
  EXPECT_EQ(limits.kind.at(20, 20), PixelKind::surface);
}

// Along a slanted ray a depth's uncertainty is the height's only in part.
TEST(PixelLimits, TheFloorsToleranceIsThatOfTheHeight) {
  const scene::CollisionWorld world{scene::Scene{}};
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(make_pose({0, 0, 0.2}, Eigen::Matrix3d::Identity()), {0.4, 0.4, 0.4}, 0.02);
  constexpr float kSigma = 0.02f;
  for (const double height : {0.5, 1.0, 1.4}) {
    DepthMap map;
    map.camera = Pinhole::from_vertical_fov(60, 60, 0.05);
    map.X_WC = look_at({2.5, 0, height}, {0, 0, 0});
    const double slope = -(map.X_WC.linear() * map.camera.back_project(30, 30, 1)).z();
    for (const auto& [sigmas, kind] : {std::pair{2.9, PixelKind::known_solid}, {3.1, PixelKind::surface}}) {
      map.depth = map.depth_minimum = ImageF(60, 60, 1, static_cast<float>(height / slope - sigmas * kSigma));
      map.depth_sigma = ImageF(60, 60, 1, kSigma);
      EXPECT_EQ(pixel_limits(map, g, kSettings, true, &world).kind.at(30, 30), kind) << height;
    }
  }
}

// From afar, where the depth's standard deviation is more than a voxel: nothing is carved out of what stands on the floor.
TEST(PixelLimits, WhatStandsOnTheFloorIsNotCarvedAwayWithIt) {
  const scene::CollisionWorld world{scene::Scene{}};
  const Sphere sphere{{0, 0, 0.15}, 0.15};
  const ObjectBox box = box_around(sphere, 0.4);
  const voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(box.X_WB, box.size, 0.01));
  DepthMap map = ideal_depth(sphere, look_at({2.8, 0, 1.3}, sphere.center), Pinhole::from_vertical_fov(640, 480, 0.2));
  for (const float sigma : {0.0f, 0.02f, 0.04f, 8.0f}) {
    map.depth_sigma = ImageF(640, 480, 1, sigma);
    const PixelLimits limits = pixel_limits(map, grid.geometry(), kSettings, true, &world);
    const auto on_floor = std::count(limits.kind.data.begin(), limits.kind.data.end(), PixelKind::known_solid);
    EXPECT_EQ(on_floor > 0, sigma > 0);
    EXPECT_LT(on_floor, 4000);
    const auto plane = seen_through(grid, map.camera, map.X_WC, limits.limit, kSettings.margin_voxels);
    for_each_voxel(grid.geometry(), [&](const Eigen::Vector3i& v) {
      if (touches(grid.geometry(), v, sphere)) {
        EXPECT_FALSE(in_plane(grid, plane, v)) << v.transpose() << ", sigma " << sigma;
      }
    });
  }
}

TEST(PixelLimits, RefusesImagesThatDoNotFit) {
  Perception p = ideal_view({}, 0, 4);
  p.depth[0].depth_minimum = ImageF(3, 3);
  EXPECT_THROW(pixel_limits(p.depth[0], voxel::GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, 0.01), kSettings, true, nullptr), Error);
}

TEST(CarvingSettings, SayWhichValueIsOutOfRange) {
  CarvingSettings s;
  EXPECT_NO_THROW(s.check());
  s.margin_voxels = 0.2;
  EXPECT_THROW(s.check(), Error);
  s = {};
  s.known_points = 0;
  EXPECT_THROW(s.check(), Error);
}

}  // namespace
}  // namespace periplus::object_model
