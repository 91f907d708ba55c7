// One evaluation of a view at 640x480: each instruction set, and OctoMap's castRay over the same pixels as the baseline.
// The object: a 0.5 m box of unknown around a ball, half of it carved away as by three looks, 1.1 m from the camera.
#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include <map>
#include <numbers>

#include "common/core/random.h"
#include "common/voxel/visibility.h"

namespace periplus::voxel {
namespace {

constexpr int kViews = 32;
const Pinhole kCamera = Pinhole::from_vertical_fov(640, 480, 60 * std::numbers::pi / 180 * 0.75);

OccupancyGrid carved(int cells) {
  GridGeometry g;
  g.voxel_size = 0.5 / cells;
  g.size = {cells, cells, cells};
  g.X_WG = make_pose({-0.25, -0.25, 0.7}, Eigen::Matrix3d::Identity());
  OccupancyGrid grid(g);
  for (int x = 0; x < cells; ++x)
    for (int y = 0; y < cells; ++y)
      for (int z = 0; z < cells; ++z) {
        const Eigen::Vector3d p = 2 * (Eigen::Vector3d(x, y, z).array() + 0.5).matrix() / cells - Eigen::Vector3d::Ones();
        const double r = p.norm();
        const bool seen = p.x() > 0.2 || p.y() > 0.3;   // the looked-at sides
        if (r > 0.7 && seen) grid.set_state({x, y, z}, VoxelState::empty);
        if (r > 0.7 - 2.0 / cells && r <= 0.7 && seen) grid.set_state({x, y, z}, VoxelState::known);
      }
  return grid;
}

std::vector<Pose> views() {
  Random random(3);
  std::vector<Pose> all;
  for (int i = 0; i < kViews; ++i) {
    const double angle = random.uniform(-3.14, 3.14), height = random.uniform(1.0, 1.35);
    all.push_back(look_at({1.1 * std::cos(angle), 1.1 * std::sin(angle), height}, {0, 0, 0.95}));
  }
  return all;
}

void evaluate(benchmark::State& state, Simd simd) {
  if (!has_simd(simd)) return state.SkipWithError("this processor has no such instructions");
  const VisibilityScene scene(carved(static_cast<int>(state.range(0))));
  const std::vector<Pose> all = views();
  VisibilityWorkspace workspace;
  workspace.simd = simd;
  VisibilityResult result;
  std::size_t i = 0;
  for (auto _ : state) {
    scene.evaluate(all[i++ % all.size()], kCamera, workspace, result);
    benchmark::DoNotOptimize(result.unknown_pixels);
  }
  state.counters["unknown_px"] = static_cast<double>(result.unknown_pixels);
}

void octomap_cast_rays(benchmark::State& state) {
  const OccupancyGrid grid = carved(static_cast<int>(state.range(0)));
  octomap::OcTree tree(grid.geometry().voxel_size);
  const Eigen::Vector3i n = grid.geometry().size;
  for (int x = 0; x < n.x(); ++x)
    for (int y = 0; y < n.y(); ++y)
      for (int z = 0; z < n.z(); ++z) {
        const Eigen::Vector3d p = grid.geometry().center_world({x, y, z});
        tree.updateNode(octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())), grid.state({x, y, z}) != VoxelState::empty, true);
      }
  tree.updateInnerOccupancy();
  const std::vector<Pose> all = views();
  std::size_t i = 0, hits = 0;
  for (auto _ : state) {
    const Pose& X_WC = all[i++ % all.size()];
    const octomap::point3d origin(static_cast<float>(X_WC.translation().x()), static_cast<float>(X_WC.translation().y()), static_cast<float>(X_WC.translation().z()));
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width; ++x) {
        const Eigen::Vector3d d = X_WC.linear() * kCamera.back_project(x, y, 1);
        octomap::point3d end;
        hits += tree.castRay(origin, octomap::point3d(static_cast<float>(d.x()), static_cast<float>(d.y()), static_cast<float>(d.z())), end, true, 2.5);
      }
  }
  benchmark::DoNotOptimize(hits);
}

BENCHMARK_CAPTURE(evaluate, avx512, Simd::avx512)->Arg(64)->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(evaluate, avx2, Simd::avx2)->Arg(64)->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(evaluate, portable, Simd::portable)->Arg(64)->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK(octomap_cast_rays)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond)->Iterations(4);

}  // namespace
}  // namespace periplus::voxel
