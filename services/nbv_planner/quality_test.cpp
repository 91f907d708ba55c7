#include "services/nbv_planner/quality.h"

#include <gtest/gtest.h>

#include <cmath>

#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

Situation known_block() {
  return testing::around_the_origin(15, [](int x, int y, int z) {
    const bool inside = x > 1 && x < 13 && y > 1 && y < 13 && z > 1 && z < 13;
    return inside ? voxel::VoxelState::known : voxel::VoxelState::empty;
  });
}

Pose in_front(double distance, double turn = 0) {  // of the face at +x (x = 0.11), the pair's middle at y = 0
  const Eigen::Vector3d middle(0.11 + distance * std::cos(turn), distance * std::sin(turn), 1.1);
  return look_along(middle, std::numbers::pi + turn, 0) * Pose(Eigen::Translation3d(-0.072, 0, 0));
}

TEST(Quality, SurfaceHasItsNormals) {
  const Situation s = known_block();
  const auto surface = known_surface(*s.grid);
  EXPECT_EQ(surface.size(), 11u * 11 * 11 - 9 * 9 * 9);
  for (const SurfaceVoxel& v : surface) {
    EXPECT_NEAR(v.normal_W.norm(), 1, 1e-12);
    const Eigen::Vector3d from_middle = v.p_W - Eigen::Vector3d(0, 0, 1.1);
    EXPECT_GT(v.normal_W.dot(from_middle), 0);
    const bool on_front = from_middle.tail<2>().cwiseAbs().maxCoeff() < 0.05 && from_middle.x() > 0.09;
    EXPECT_NEAR(v.normal_W.x(), on_front ? 1 : v.normal_W.x(), 1e-9);
  }
}

TEST(Quality, FallsWithAngleAndDistance) {
  SurfaceVoxel s;
  s.p_W = {0, 0, 0};
  s.normal_W = {1, 0, 0};
  const auto from = [&](double x, double y) { return look_quality(s, look_at(Eigen::Vector3d(x, y, 0), Eigen::Vector3d::Zero()), 0, 1); };
  EXPECT_NEAR(from(1, 0), 1, 1e-12);
  EXPECT_NEAR(from(0.7, 0), 1, 1e-12);  // no better than at the reference distance
  EXPECT_NEAR(from(2, 0), 0.25, 1e-12);
  EXPECT_NEAR(from(0.5, std::sqrt(0.75)), 0.5, 1e-12);  // 60 degrees
  EXPECT_EQ(from(-1, 0), 0);
  s.normal_W.setZero();
  EXPECT_NEAR(from(-2, 0), 0.25, 1e-12);
}

TEST(Quality, BestLookCountsAndOnlyWhatIsSeen) {
  Situation s = known_block();
  s.views = {in_front(1.5), in_front(1.2, 0.3)};
  const auto surface = known_surface(*s.grid);
  std::vector<Eigen::Vector3i> watched;
  for (const auto& v : surface) watched.push_back(s.grid->geometry().voxel_of(v.p_W));
  const voxel::VisibilityScene scene(*s.grid, {}, watched);
  const auto quality = quality_so_far(surface, s, scene, {}, 1);
  int front = 0, back = 0;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const Eigen::Vector3d& p = surface[i].p_W;
    if (p.x() < -0.09) {
      EXPECT_EQ(quality[i], 0);
      ++back;
    } else if (p.x() > 0.09 && std::abs(p.y()) < 0.08 && std::abs(p.z() - 1.1) < 0.08) {
      const double best = std::max(look_quality(surface[i], s.views[0], 0.144, 1), look_quality(surface[i], s.views[1], 0.144, 1));
      EXPECT_NEAR(quality[i], best, 1e-6);
      EXPECT_GT(quality[i], 0.4);
      ++front;
    }
  }
  EXPECT_GT(front, 40);
  EXPECT_EQ(back, 11 * 11);
}

TEST(Quality, ABetterLookIsWorthSomethingTheSameLookNothing) {
  Situation s = known_block();
  s.views = {in_front(2.0)};
  EvaluationSettings settings;
  settings.quality_weight = 0.5;
  settings.quality_reference = 1;
  const Evaluator evaluator(s, settings, {});
  Evaluator::Workspace w;
  EXPECT_NEAR(evaluator.evaluate(s.views[0], w).value, 0, 1e-4);
  const Evaluation nearer = evaluator.evaluate(in_front(1.0), w);
  EXPECT_EQ(nearer.gain.voxels, 0);  // everything is known
  // The face of 11 x 11, but for its edges, goes from (1/2)^2 to 1.
  double expected = 0;
  for (const SurfaceVoxel& v : known_surface(*s.grid)) {
    if (v.p_W.x() > 0.09) expected += look_quality(v, in_front(1.0), 0.144, 1) - look_quality(v, s.views[0], 0.144, 1);
  }
  EXPECT_GT(expected, 0.5 * 121);
  EXPECT_NEAR(nearer.value, 0.5 * expected, 1e-3);
  EXPECT_NEAR(nearer.quality, nearer.value / 0.5, 1e-9);
  settings.quality_weight = 0;
  EXPECT_EQ(Evaluator(s, settings, {}).evaluate(in_front(1.0), w).value, 0);
}

}  // namespace
}  // namespace periplus::nbv
