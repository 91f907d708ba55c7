#include "services/nbv_planner/thesis_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "common/core/error.h"
#include "services/nbv_planner/testing/situations.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv {
namespace {

constexpr ThesisLocal kLocals[] = {ThesisLocal::bobyqa, ThesisLocal::newuoa, ThesisLocal::nelder_mead, ThesisLocal::none};

SearchSettings thesis(ThesisLocal local, int evaluations) {
  SearchSettings s;
  s.method = SearchMethod::thesis;
  s.thesis.local = local;
  s.max_evaluations = evaluations;
  return s;
}

TEST(ThesisSearch, EveryLocalMethodFindsTheOnlyUnknownSide) {
  const Situation s = testing::patch_at_plus_x();
  for (const ThesisLocal local : kLocals) {
    const PlannedView v = plan_view(s, 1, thesis(local, 500), {}, {});
    EXPECT_GT(v.X_WC.translation().x(), 0.5);
    EXPECT_GE(v.evaluation.gain.voxels, 215) << static_cast<int>(local);  // of 225
    EXPECT_EQ(v.evaluation.violation, Violation::none);
    EXPECT_LE(v.evaluations, 500);
    EXPECT_GT(v.evaluations, 100);
  }
}

TEST(ThesisSearch, LocalSearchesImproveTheSamples) {
  const Situation s = testing::around_the_origin(25, [](int x, int y, int z) {
    const double r = std::hypot(x - 12, y - 12) + 3 * std::sin(z * 0.7 + x * 0.5);
    return r > 11 ? voxel::VoxelState::empty : (x + 2 * y) % 11 < 6 && x > 8 ? voxel::VoxelState::unknown : voxel::VoxelState::known;
  });
  for (const ThesisLocal local : kLocals) {
    SearchSettings search = thesis(local, 400);
    search.thesis.samples = 60;
    search.keep_candidates = true;
    const PlannedView v = plan_view(s, 2, search, {}, {});
    double samples = 1e300;
    for (const ViewCandidate& c : v.candidates) {
      if (std::strcmp(c.stage, "sampling") == 0) samples = std::min(samples, c.f_e);
      EXPECT_LE(v.f_e, c.f_e + 1e-9);  // never worse than what was looked at
    }
    EXPECT_EQ(v.candidates.empty(), false);
    if (local == ThesisLocal::none) continue;
    EXPECT_LT(v.f_e, samples) << static_cast<int>(local);
  }
}

TEST(ThesisSearch, RollsWhereTheLimitsAllowIt) {
  Situation s = testing::patch_at_plus_x();
  s.limits.roll_max = 0.3;
  const PlannedView v = plan_view(s, 3, thesis(ThesisLocal::bobyqa, 300), {}, {});
  EXPECT_NE(camera_yaw_pitch_roll(v.X_WC).z(), 0);
  EXPECT_LE(std::abs(camera_yaw_pitch_roll(v.X_WC).z()), 0.3 + 1e-9);
}

TEST(ThesisSearch, SamplesInsideALargeHollowObject) {
  // A shell of 2.4 m with a robot's room inside; only its inner side is unknown.
  voxel::GridGeometry g;
  g.voxel_size = 0.1;
  g.size = {32, 32, 16};
  g.X_WG = make_pose({-1.6, -1.6, 0.6}, Eigen::Matrix3d::Identity());
  auto grid = std::make_shared<voxel::OccupancyGrid>(g);
  for (int x = 0; x < 32; ++x)
    for (int y = 0; y < 32; ++y)
      for (int z = 0; z < 16; ++z) {
        const int d = std::min({x, y, 31 - x, 31 - y});
        grid->set_state({x, y, z}, d > 1 ? voxel::VoxelState::empty : d == 1 ? voxel::VoxelState::unknown : voxel::VoxelState::known);
      }
  grid->revision = 1;
  Situation s;
  s.grid = grid;
  s.scene.room.size = {9, 9, 2.8};
  s.collision = std::make_shared<scene::CollisionWorld>(s.scene);
  s.rig = {Pinhole::from_vertical_fov(640, 480, 25 * std::numbers::pi / 180), 0.144};
  for (const SearchMethod method : {SearchMethod::thesis, SearchMethod::fast}) {
    SearchSettings search = thesis(ThesisLocal::bobyqa, 300);
    search.method = method;
    const PlannedView v = plan_view(s, 4, search, {}, {});
    EXPECT_LT(v.X_WC.translation().head<2>().lpNorm<Eigen::Infinity>(), 1.2);
    EXPECT_GT(v.evaluation.gain.voxels, 10);
  }
}

TEST(ThesisSearch, BadNumbersAreRefused) {
  const Situation s = testing::patch_at_plus_x();
  SearchSettings search = thesis(ThesisLocal::bobyqa, 300);
  search.thesis.starts = 0;
  EXPECT_THROW(plan_view(s, 1, search, {}, {}), Error);
  search = thesis(ThesisLocal::bobyqa, 2);
  EXPECT_THROW(plan_view(s, 1, search, {}, {}), Error);
}

}  // namespace
}  // namespace periplus::nbv
