#include "common/voxel/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/core/testing/no_threads.h"
#include "common/voxel/testing/carved_object.h"
#include "common/voxel/testing/random_scene.h"
#include "common/voxel/testing/ray_caster.h"

namespace periplus::voxel {
namespace {

using testing::carved_object;
using testing::center;
using testing::difference;
using testing::random_grid;
using testing::random_view;
using testing::ray_cast;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Solid {
  enum Kind { box, cylinder, sphere } kind;
  Pose X_WS;
  Eigen::Vector3d size;

  Occluder occluder() const {
    if (kind == box) return Occluder::box(X_WS, size);
    if (kind == cylinder) return Occluder::cylinder(X_WS, size.x(), size.z());
    return Occluder::sphere(X_WS.translation(), size.x());
  }
  // Where a ray enters the solid: multiples of `d`, infinity if it misses.
  double entry(const Eigen::Vector3d& p_W, const Eigen::Vector3d& d_W) const {
    const Eigen::Vector3d p = X_WS.inverse() * p_W, d = X_WS.linear().transpose() * d_W;
    double t0 = 0, t1 = kInfinity;
    const auto slab = [&](int axis) {
      const double h = size[axis] / 2;
      double a = (-h - p[axis]) / d[axis], b = (h - p[axis]) / d[axis];
      if (a > b) std::swap(a, b);
      t0 = std::max(t0, a);
      t1 = std::min(t1, b);
    };
    const auto quadric = [&](double aa, double bb, double cc) {
      const double root = bb * bb - aa * cc;
      if (root < 0) {
        t1 = -1;
        return;
      }
      t0 = std::max(t0, (-bb - std::sqrt(root)) / aa);
      t1 = std::min(t1, (-bb + std::sqrt(root)) / aa);
    };
    const double r = size.x() / 2;
    switch (kind) {
      case box:
        for (int a = 0; a < 3; ++a) slab(a);
        break;
      case cylinder:
        slab(2);
        quadric(d.head<2>().squaredNorm(), p.head<2>().dot(d.head<2>()), p.head<2>().squaredNorm() - r * r);
        break;
      case sphere:
        quadric(d.squaredNorm(), p.dot(d), p.squaredNorm() - r * r);
        break;
    }
    return t0 < t1 ? t0 : kInfinity;
  }
};

testing::Hidden hidden_by(const std::vector<Solid>& solids) {
  return [&solids](const Eigen::Vector3d& p_W, const Eigen::Vector3d& d_W, double box_entry) {
    return std::any_of(solids.begin(), solids.end(), [&](const Solid& s) { return s.entry(p_W, d_W) < box_entry; });
  };
}

const Pinhole kCamera = Pinhole::from_vertical_fov(200, 150, 0.6);

TEST(Visibility, AgreesWithRayCastingFromOutside) {
  Random random(1);
  std::uint64_t wrong = 0, all = 0;
  for (int i = 0; i < 24; ++i) {
    const Eigen::Vector3i size(9 + random.below(20), 7 + random.below(20), 8 + random.below(20));
    const OccupancyGrid grid = random_grid(random, size, i % 3 == 0 ? 0.9 : i % 3 == 1 ? 0.2 : 0.03);
    const VisibilityScene scene(grid);
    const Pose X_WC = random_view(random, grid.geometry(), 0.6, 1.5);
    const VisibilityResult r = scene.evaluate(X_WC, kCamera);
    wrong += difference(ray_cast(grid, X_WC, kCamera), r);
    all += r.unknown_pixels + r.known_pixels + r.environment_pixels;
    std::uint64_t listed = 0;
    for (const auto& v : r.unknown) listed += v.pixels;
    EXPECT_EQ(listed, r.unknown_pixels);
  }
  EXPECT_GT(all, 50000u);
  EXPECT_LE(wrong, all / 20000);  // rounding at pixel centres on an edge
}

// As the planner uses it: 640 x 480, objects carved by looks, and noise of every density. N_u as a whole may be off by a share of
// 1e-4 (by a voxel in a view at most), which is rounding at pixel centres that lie on an edge.
TEST(Visibility, CountsWhatRaysCountAt640x480) {
  std::size_t expected_voxels = 0, wrong_voxels = 0;
  std::uint64_t pixels = 0, wrong_pixels = 0;
  const auto compare = [&](const OccupancyGrid& grid, const Pose& X_WC, const Pinhole& camera) {
    const testing::RayCastView expected = ray_cast(grid, X_WC, camera);
    const VisibilityResult r = VisibilityScene(grid).evaluate(X_WC, camera);
    const std::size_t voxels = static_cast<std::size_t>(std::count_if(r.unknown.begin(), r.unknown.end(), [](const auto& v) { return v.pixels > 5; }));
    const std::size_t off = std::max(voxels, expected.voxels(5)) - std::min(voxels, expected.voxels(5));
    EXPECT_LE(static_cast<double>(off), std::max(1.0, 1e-4 * static_cast<double>(expected.voxels(5))));
    expected_voxels += expected.voxels(5);
    wrong_voxels += off;
    pixels += r.unknown_pixels + r.known_pixels + r.environment_pixels;
    wrong_pixels += difference(expected, r);
  };
  for (int looks : {1, 4}) {
    const auto object = carved_object(96, 0.5, looks);
    for (const Pose& X_WC : testing::views_of(object, 0.5, 4, 3)) compare(object.grid, X_WC, testing::carved_object_camera());
  }
  Random random(12);
  for (double fill : {0.9, 0.3, 0.05, 0.01}) {
    const OccupancyGrid grid = random_grid(random, {50, 40, 45}, fill);
    for (int i = 0; i < 2; ++i) compare(grid, random_view(random, grid.geometry(), 0.9, 2.0), Pinhole::from_vertical_fov(640, 480, 0.6));
  }
  EXPECT_GT(expected_voxels, 30000u);
  EXPECT_LE(static_cast<double>(wrong_voxels), 1e-4 * static_cast<double>(expected_voxels));
  EXPECT_LE(static_cast<double>(wrong_pixels), 1e-4 * static_cast<double>(pixels));
}

TEST(Visibility, AgreesWithRayCastingFromInsideTheBox) {
  Random random(2);
  std::uint64_t wrong = 0, all = 0;
  for (int i = 0; i < 16; ++i) {
    OccupancyGrid grid = random_grid(random, {24, 24, 24}, 0.05);
    const Pose X_WC = random_view(random, grid.geometry(), 0.0, 0.15);
    const Eigen::Vector3i own = grid.geometry().voxel_of(X_WC.translation());
    grid.set_state(own, VoxelState::empty);
    const VisibilityScene scene(grid);
    const VisibilityResult r = scene.evaluate(X_WC, kCamera);
    wrong += difference(ray_cast(grid, X_WC, kCamera), r);
    all += r.unknown_pixels + r.known_pixels + r.environment_pixels;
  }
  EXPECT_GT(all, 100000u);
  // Of voxels nearer than 1 mm to the camera's plane the kernel cuts the front off, the ray caster does not.
  EXPECT_LE(wrong, all / 5000);
}

TEST(Visibility, SolidsOutsideTheGridHideIt) {
  Random random(3);
  std::uint64_t wrong = 0, all = 0, occluded = 0;
  for (int i = 0; i < 30; ++i) {
    const OccupancyGrid grid = random_grid(random, {20, 24, 17}, 0.5);
    std::vector<Solid> solids;
    std::vector<Occluder> occluders;
    for (int k = 0; k < 3; ++k) {
      const Pose X = random_view(random, grid.geometry(), 0.2, 0.8);  // some reach into the box, some to the camera
      const auto side = [&] { return random.uniform(0.05, 0.4); };
      solids.push_back({static_cast<Solid::Kind>((i + k) % 2), X, {side(), side(), side()}});
      occluders.push_back(solids.back().occluder());
    }
    const VisibilityScene scene(grid, occluders);
    const Pose X_WC = random_view(random, grid.geometry(), 0.6, 1.2);
    bool inside = false;
    for (const Solid& s : solids) inside |= (s.X_WS.inverse() * X_WC.translation()).norm() < 0.35;
    if (inside) continue;
    const VisibilityResult r = scene.evaluate(X_WC, kCamera);
    wrong += difference(ray_cast(grid, X_WC, kCamera, hidden_by(solids)), r);
    all += r.unknown_pixels + r.known_pixels + r.environment_pixels;
    occluded += r.occluder_pixels;
  }
  EXPECT_GT(all, 50000u);
  EXPECT_GT(occluded, 20000u);
  EXPECT_LE(wrong, all / 500);  // the 64-sided prism
}

TEST(Visibility, SphereHidesAsASphere) {
  Random random(4);
  const OccupancyGrid grid = random_grid(random, {20, 20, 20}, 1.0);
  const Pose X_WC = random_view(random, grid.geometry(), 1.0, 1.0);
  const Solid ball{Solid::sphere, make_pose((X_WC.translation() + center(grid.geometry())) / 2, Eigen::Matrix3d::Identity()),
                   {0.1, 0.1, 0.1}};
  const VisibilityScene scene(grid, {ball.occluder()});
  const VisibilityResult r = scene.evaluate(X_WC, kCamera);
  EXPECT_GT(r.occluder_pixels, 500u);
  EXPECT_LE(difference(ray_cast(grid, X_WC, kCamera, hidden_by({ball})), r), r.occluder_pixels / 100 + 5);
}

// A mesh hides what rays through its triangles say (Moeller and Trumbore, 1997), whether it is closed or not.
TEST(Visibility, MeshesOutsideTheGridHideIt) {
  Random random(14);
  std::uint64_t wrong = 0, all = 0, occluded = 0;
  for (int i = 0; i < 12; ++i) {
    const OccupancyGrid grid = random_grid(random, {20, 24, 17}, 0.5);
    const Pose X_WC = random_view(random, grid.geometry(), 0.9, 1.2);
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Eigen::Vector3i> triangles;
    for (int k = 0; k < 12; ++k) {  // between the camera and the grid, and into it
      const Eigen::Vector3d middle = X_WC.translation() + random.uniform(0.2, 1.0) * (center(grid.geometry()) - X_WC.translation());
      for (int c = 0; c < 3; ++c) vertices.push_back(middle + 0.15 * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
      triangles.emplace_back(3 * k, 3 * k + 1, 3 * k + 2);
    }
    const auto hidden = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& d, double box_entry) {
      for (const Eigen::Vector3i& t : triangles) {
        const Eigen::Vector3d a = vertices[t[0]], e = vertices[t[1]] - a, f = vertices[t[2]] - a, h = d.cross(f), s = p - a, q = s.cross(e);
        const double det = e.dot(h), u = s.dot(h) / det, v = d.dot(q) / det, at = f.dot(q) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && at > 0 && at < box_entry) return true;
      }
      return false;
    };
    const VisibilityResult r = VisibilityScene(grid, Occluder::mesh(vertices, triangles)).evaluate(X_WC, kCamera);
    wrong += difference(ray_cast(grid, X_WC, kCamera, hidden), r);
    all += r.unknown_pixels + r.known_pixels + r.environment_pixels;
    occluded += r.occluder_pixels;
  }
  EXPECT_GT(all, 20000u);
  EXPECT_GT(occluded, 20000u);
  EXPECT_LE(wrong, all / 5000);
  EXPECT_THROW(Occluder::mesh({{0, 0, 0}}, {{0, 0, 1}}), Error);
}

TEST(Visibility, WatchedVoxelsAreListed) {
  Random random(5);
  const OccupancyGrid grid = random_grid(random, {16, 16, 16}, 1.0);
  std::vector<Eigen::Vector3i> watched;
  for (int y = 0; y < 16; ++y) {
    for (int z = 0; z < 16; ++z) watched.emplace_back(15, y, z);
  }
  watched.emplace_back(99, 0, 0);  // outside: left out
  const VisibilityScene scene(grid, {}, watched);
  const Eigen::Vector3d out = grid.geometry().X_WG.linear().col(0);
  const VisibilityResult r = scene.evaluate(look_at(center(grid.geometry()) + out, center(grid.geometry())), kCamera);
  EXPECT_EQ(r.watched.size(), 256u);  // that whole side, seen face on
  std::uint64_t sum = 0;
  for (const auto& v : r.watched) {
    sum += v.pixels;
    EXPECT_EQ(scene.voxel(v.voxel).x(), 15);
  }
  EXPECT_EQ(sum, r.unknown_pixels + r.known_pixels + r.environment_pixels);
}

TEST(Visibility, PairCountsWhatBothEyesSeeWithinTheRange) {
  GridGeometry g;
  g.X_WG = make_pose({0, -0.04, 0}, Eigen::Matrix3d::Identity());
  g.voxel_size = 0.01;
  g.size = {1, 80, 8};  // a wall of 0.8 m by 8 cm, 1 cm thick, seen along +x
  const OccupancyGrid grid(g);
  const VisibilityScene scene(grid);
  StereoRig rig{Pinhole::from_vertical_fov(640, 480, 25 * std::numbers::pi / 180), 0.144};
  VisibilityWorkspace workspace;
  // Left eye 1 m away at the wall's middle; the wall fills the images' width (0.59 m), of which both share 0.447 m.
  const Pose X_WC = look_along({-1, 0.36, 0.04}, 0, 0);
  const PairGain gain = scene.evaluate_pair(X_WC, rig, {}, workspace);
  const double share = 2 * std::tan(rig.camera.horizontal_fov() / 2) - 0.144;
  EXPECT_NEAR(gain.voxels, share / 0.01 * 8, 2 * 8);
  EXPECT_NEAR(double(gain.pixels), share * rig.camera.fx * 0.08 * rig.camera.fy, 0.04 * double(gain.pixels));
  EXPECT_GT(workspace.left.unknown.size(), static_cast<std::size_t>(gain.voxels) + 50);
  // Out of the depth range nothing counts; a threshold above a voxel's size neither.
  EXPECT_EQ(scene.evaluate_pair(X_WC, rig, {.depth_min = 1.1}, workspace).voxels, 0);
  EXPECT_EQ(scene.evaluate_pair(X_WC, rig, {.depth_max = 0.9}, workspace).pixels, 0u);
  EXPECT_EQ(scene.evaluate_pair(X_WC, rig, {.more_than_pixels = 150}, workspace).voxels, 0);
  EXPECT_EQ(scene.evaluate_pair(X_WC, rig, {}, workspace).voxels, gain.voxels);  // the workspace keeps nothing
}

// A thread for the right eye changes nothing, and what that thread throws comes out.
TEST(Visibility, EyesSideBySideSeeTheSame) {
  Random random(15);
  const StereoRig rig{Pinhole::from_vertical_fov(320, 240, 0.6), 0.1};
  const auto entries = [](const VoxelList& list) {
    std::vector<std::array<std::uint32_t, 2>> all;
    for (const VoxelPixels& v : list) all.push_back({v.voxel, v.pixels});
    return all;
  };
  std::size_t seen = 0;
  VisibilityWorkspace one, two;
  two.beside = std::make_unique<VisibilityWorkspace>();
  for (int i = 0; i < 10; ++i) {
    const OccupancyGrid grid = random_grid(random, {30, 26, 28}, 0.3);
    const VisibilityScene scene(grid);
    const Pose X_WC = random_view(random, grid.geometry(), 0.0, 1.0);
    const PairGain a = scene.evaluate_pair(X_WC, rig, {.depth_min = 0, .more_than_pixels = 1}, one), b = scene.evaluate_pair(X_WC, rig, {.depth_min = 0, .more_than_pixels = 1}, two);
    EXPECT_EQ(a.voxels, b.voxels);
    EXPECT_EQ(a.pixels, b.pixels);
    EXPECT_EQ(entries(one.left.unknown), entries(two.left.unknown));
    EXPECT_EQ(entries(one.right.unknown), entries(two.right.unknown));
    EXPECT_EQ(entries(one.both), entries(two.both));
    seen += one.both.size();
    Pose nowhere = X_WC;
    nowhere.translation().x() = std::nan("");
    EXPECT_THROW(scene.evaluate_pair(nowhere, rig, {}, two), Error);
  }
  EXPECT_GT(seen, 500u);
}

// A process may have no thread left: one looks through both eyes then.
TEST(Visibility, EyesSideBySideSeeTheSameWithoutASecondThread) {
  Random random(16);
  const OccupancyGrid grid = random_grid(random, {30, 26, 28}, 0.3);
  const VisibilityScene scene(grid);
  const Pose X_WC = random_view(random, grid.geometry(), 0.0, 1.0);
  const StereoRig rig{Pinhole::from_vertical_fov(320, 240, 0.6), 0.1};
  VisibilityWorkspace one, two;
  two.beside = std::make_unique<VisibilityWorkspace>();
  const PairGain a = scene.evaluate_pair(X_WC, rig, {.depth_min = 0, .more_than_pixels = 1}, one);
  const NoThreads none;
  const PairGain b = scene.evaluate_pair(X_WC, rig, {.depth_min = 0, .more_than_pixels = 1}, two);
  EXPECT_GT(a.voxels, 0);
  EXPECT_EQ(a.voxels, b.voxels);
  EXPECT_EQ(a.pixels, b.pixels);
}

// The options leave out exactly what they say: the same list as an evaluation of everything, filtered.
TEST(Visibility, RangeAndThresholdFilterTheList) {
  Random random(8);
  std::size_t listed = 0, dropped = 0;
  for (int i = 0; i < 12; ++i) {
    const OccupancyGrid grid = random_grid(random, {30, 26, 28}, i % 2 == 0 ? 0.9 : 0.1);
    std::vector<Eigen::Vector3i> watched;
    for (int k = 0; k < 300; ++k) watched.emplace_back(random.below(30), random.below(26), random.below(28));
    const VisibilityScene scene(grid, {}, watched);
    const Pose X_WC = random_view(random, grid.geometry(), 0.0, 1.0);
    const double middle = (X_WC.inverse() * center(grid.geometry())).z();
    const ViewOptions options{middle - 0.15, middle + 0.1, 8};
    const VisibilityResult all = scene.evaluate(X_WC, kCamera), some = scene.evaluate(X_WC, kCamera, options);
    std::uint64_t pixels = 0;
    const auto filtered = [&](const VoxelList& list, bool sum) {
      std::vector<std::uint32_t> kept;
      for (const VoxelPixels& v : list) {
        const double depth = (X_WC.inverse() * grid.geometry().center_world(scene.voxel(v.voxel))).z();
        if (depth < options.depth_min || depth > options.depth_max) continue;
        if (sum) pixels += v.pixels;
        if (v.pixels > 8) kept.push_back(v.voxel);
      }
      return kept;
    };
    const auto voxels = [](const VoxelList& list) {
      std::vector<std::uint32_t> v;
      for (const VoxelPixels& p : list) v.push_back(p.voxel);
      return v;
    };
    EXPECT_EQ(voxels(some.unknown), filtered(all.unknown, true));
    EXPECT_EQ(some.unknown_pixels, pixels);
    EXPECT_EQ(voxels(some.watched), filtered(all.watched, false));
    listed += some.unknown.size();
    dropped += all.unknown.size() - some.unknown.size();
  }
  EXPECT_GT(listed, 200u);
  EXPECT_GT(dropped, 1000u);
}

// What is drawn where nothing counts is left out; the lists must be the same, in the same order.
TEST(Visibility, UnknownAloneListsTheSame) {
  Random random(23);
  std::size_t listed = 0, left_out = 0;
  const auto same = [&](const VoxelList& a, const VoxelList& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(a[i].voxel == b[i].voxel && a[i].pixels == b[i].pixels) << i;
  };
  const auto compare = [&](const VisibilityScene& scene, const Pose& X_WC, const Pinhole& camera, ViewOptions options) {
    for (Simd simd : {Simd::portable, Simd::avx2, Simd::avx512, Simd::avx512_popcnt}) {
      if (!has_simd(simd)) continue;
      VisibilityWorkspace w;
      w.simd = simd;
      options.unknown_alone = false;
      scene.evaluate(X_WC, camera, options, w, w.left);
      options.unknown_alone = true;
      scene.evaluate(X_WC, camera, options, w, w.right);
      same(w.left.unknown, w.right.unknown);
      same(w.left.watched, w.right.watched);
      EXPECT_EQ(w.left.unknown_pixels, w.right.unknown_pixels);
      EXPECT_EQ(w.right.known_pixels + w.right.environment_pixels + w.right.occluder_pixels, 0u);
      listed += w.right.unknown.size() + w.right.watched.size();
      left_out += w.left.known_pixels;
    }
  };
  for (int looks : {1, 6}) {
    const testing::CarvedObject object = carved_object(64, 0.5, looks);
    const VisibilityScene scene(object.grid, object.occluders, object.watched);
    for (const Pose& X_WC : testing::views_of(object, 0.5, 12, 3)) {
      compare(scene, X_WC, testing::carved_object_camera(), {});
      compare(scene, X_WC, testing::carved_object_camera(), {0.8, 1.3, 5});
    }
  }
  for (int trial = 0; trial < 20; ++trial) {
    // All known but a few: from outside, and from inside the box too.
    OccupancyGrid grid = random_grid(random, {30, 26, 28}, 0.3);
    const Eigen::Vector3i size = grid.geometry().size;
    for (std::size_t i = 0; i < grid.known().size(); ++i) grid.known()[i] = grid.occupied()[i] & ~grid.environment()[i];
    for (int i = 0; i < 12; ++i) {
      const Eigen::Vector3i v(static_cast<int>(random.below(size.x())), static_cast<int>(random.below(size.y())), static_cast<int>(random.below(size.z())));
      if (grid.state(v) == VoxelState::known) grid.set_state(v, VoxelState::unknown);
    }
    const Eigen::Vector3d middle = center(grid.geometry());
    const VisibilityScene scene(grid, {Occluder::sphere(middle + Eigen::Vector3d(0.5, 0.1, 0.2), 0.1)});
    compare(scene, random_view(random, grid.geometry(), 0.3, 1.2), kCamera, {});
    compare(scene, look_along(middle, random.uniform(-3, 3), random.uniform(-1, 1)), kCamera, {});
  }
  EXPECT_GT(listed, 20000u);
  EXPECT_GT(left_out, 1000000u);
}

TEST(Visibility, PairListsWhatBothEyesSee) {
  Random random(9);
  const OccupancyGrid grid = random_grid(random, {30, 30, 30}, 0.6);
  const VisibilityScene scene(grid);
  VisibilityWorkspace w;
  const StereoRig rig{kCamera, 0.1};
  for (int i = 0; i < 6; ++i) {
    const Pose X_WC = random_view(random, grid.geometry(), 0.7, 1.2);
    const PairGain gain = scene.evaluate_pair(X_WC, rig, {}, w);
    std::map<std::uint32_t, std::uint32_t> right;
    for (const auto& v : w.right.unknown) right[v.voxel] = v.pixels;
    std::map<std::uint32_t, std::uint32_t> expected, both;
    for (const auto& v : w.left.unknown) {
      if (right.contains(v.voxel)) expected[v.voxel] = std::min(v.pixels, right[v.voxel]);
    }
    std::uint64_t pixels = 0;
    int voxels = 0;
    for (const auto& v : w.both) {
      both[v.voxel] = v.pixels;
      pixels += v.pixels;
      voxels += v.pixels > 5;
    }
    EXPECT_EQ(both, expected);
    EXPECT_EQ(gain.pixels, pixels);
    EXPECT_EQ(gain.voxels, voxels);
    EXPECT_GT(gain.voxels, 50);
  }
}

TEST(Visibility, RigWithoutBaselineIsOneCamera) {
  Random random(10);
  const OccupancyGrid grid = random_grid(random, {30, 30, 30}, 0.6);
  const VisibilityScene scene(grid);
  const Pose X_WC = random_view(random, grid.geometry(), 0.8, 1.0);
  VisibilityWorkspace w;
  const PairGain gain = scene.evaluate_pair(X_WC, {kCamera, 0}, {}, w);
  const VisibilityResult one = scene.evaluate(X_WC, kCamera, {0.6, 2.5, 5});
  EXPECT_EQ(static_cast<std::size_t>(gain.voxels), one.unknown.size());
  EXPECT_EQ(gain.pixels, one.unknown_pixels);
  EXPECT_EQ(w.both.size(), w.left.unknown.size());
  EXPECT_TRUE(w.right.unknown.empty());
  EXPECT_GT(gain.voxels, 100);
}

// A part of a large panorama, its axis outside of the image, shows what the panorama shows there.
TEST(Visibility, AnyPinholeWindow) {
  Random random(11);
  const OccupancyGrid grid = random_grid(random, {30, 30, 30}, 0.4);
  const VisibilityScene scene(grid);
  const Pose X_WC = random_view(random, grid.geometry(), 0.5, 0.5);
  Pinhole whole = Pinhole::from_vertical_fov(2560, 1920, 1.2), part = whole;
  const VisibilityResult all = scene.evaluate(X_WC, whole);
  EXPECT_GT(all.unknown_pixels, 200000u);
  std::uint64_t pixels = 0;
  for (int x : {0, 1300}) {
    for (int y : {0, 1000}) {
      part.width = x == 0 ? 1300 : 1260;
      part.height = y == 0 ? 1000 : 920;
      part.cx = whole.cx - x;
      part.cy = whole.cy - y;
      pixels += scene.evaluate(X_WC, part).unknown_pixels;
    }
  }
  EXPECT_NEAR(double(pixels), double(all.unknown_pixels), 1e-4 * double(pixels));
}

TEST(Visibility, RefusesWhatIsNoCamera) {
  GridGeometry g;
  g.size = {8, 8, 8};
  const VisibilityScene scene{OccupancyGrid(g)};
  Pose X = Pose::Identity();
  X.translation().x() = std::nan("");
  EXPECT_THROW(scene.evaluate(X, kCamera), Error);
  Pinhole bad = kCamera;
  bad.fx = 0;
  EXPECT_THROW(scene.evaluate(Pose::Identity(), bad), Error);
}

}  // namespace
}  // namespace periplus::voxel
