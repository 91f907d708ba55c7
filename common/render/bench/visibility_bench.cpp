// One evaluation of a view at 640x480: each instruction set, the pair of eyes, and beside them, at equal pixels and on the same
// views, OctoMap's castRay and OpenGL drawing the free faces. Objects of 0.5 m and 2 m, carved by six looks as in mid-run, among 24 solids.
// `times_octomap`: how often an evaluation fits into castRay's time in this run. N_u is the mean over the views.
#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <ctime>
#include <map>
#include <memory>
#include <utility>

#include "common/render/testing/gl_visibility.h"
#include "common/voxel/testing/carved_object.h"

namespace periplus::voxel {
namespace {

constexpr int kViews = 64, kLooks = 6;
const Pinhole kCamera = testing::carved_object_camera();

struct Case {
  testing::CarvedObject object;
  std::vector<Pose> views;
  std::unique_ptr<VisibilityScene> scene;
};

// `size` in centimetres.
const Case& scene_of(int cells, int size) {
  static std::map<std::pair<int, int>, Case> cases;
  const auto [at, is_new] = cases.try_emplace({cells, size});
  if (is_new) {
    at->second.object = testing::carved_object(cells, size / 100.0, kLooks);
    at->second.views = testing::views_of(at->second.object, size / 100.0, kViews, 11);
    at->second.scene = std::make_unique<VisibilityScene>(at->second.object.grid, at->second.object.occluders, at->second.object.watched);
  }
  return at->second;
}

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

octomap::OcTree octree_of(const OccupancyGrid& grid) {
  octomap::OcTree tree(grid.geometry().voxel_size);
  const Eigen::Vector3i n = grid.geometry().size;
  for (int x = 0; x < n.x(); ++x)
    for (int y = 0; y < n.y(); ++y)
      for (int z = 0; z < n.z(); ++z) {
        const VoxelState voxel = grid.state({x, y, z});
        if (voxel == VoxelState::unknown) continue;  // as OctoMap has it: no node
        const Eigen::Vector3d p = grid.geometry().center_world({x, y, z});
        tree.setNodeValue(octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())), voxel == VoxelState::empty ? -2.0f : 2.0f, true);
      }
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

// As cheaply as it can be asked: each ray only from where it enters the grid's box to where it leaves it.
std::size_t cast_all(const octomap::OcTree& tree, const GridGeometry& g, const Pose& X_WC) {
  std::size_t hits = 0;
  const Pose X_GC = g.X_WG.inverse() * X_WC;
  const Eigen::Vector3d o = X_GC.translation(), size = g.size.cast<double>() * g.voxel_size;
  const auto point = [](const Eigen::Vector3d& p) { return octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())); };
  for (int y = 0; y < kCamera.height; ++y)
    for (int x = 0; x < kCamera.width; ++x) {
      const Eigen::Vector3d d = (X_GC.linear() * kCamera.back_project(x, y, 1)).normalized();
      const Eigen::Array3d a = -o.array() / d.array(), b = (size - o).array() / d.array();
      const double enter = std::max(0.0, a.min(b).maxCoeff()), leave = a.max(b).minCoeff();
      if (enter >= leave) continue;
      octomap::point3d end;
      hits += tree.castRay(point(g.X_WG * (o + (enter + 1e-6) * d)), point(g.X_WG.linear() * d), end, false, leave - enter);  // stops at unknown too
    }
  return hits;
}

// CPU time of OctoMap's castRay over all pixels of a view, mean of four [s]; once a run for each scene.
double octomap_seconds(int cells, int size) {
  static std::map<std::pair<int, int>, double> known;
  const auto [at, is_new] = known.try_emplace({cells, size}, 0.0);
  if (is_new) {
    const Case& c = scene_of(cells, size);
    const octomap::OcTree tree = octree_of(c.object.grid);
    const double start = cpu_seconds();
    for (int i = 0; i < 4; ++i) benchmark::DoNotOptimize(cast_all(tree, c.object.grid.geometry(), c.views[static_cast<std::size_t>(i)]));
    at->second = (cpu_seconds() - start) / 4;
  }
  return at->second;
}

void evaluate(benchmark::State& state, Simd simd) {
  if (!has_simd(simd)) return state.SkipWithError("this processor has no such instructions");
  const int cells = static_cast<int>(state.range(0)), size = static_cast<int>(state.range(1));
  const Case& c = scene_of(cells, size);
  const double octomap = cells <= 128 ? octomap_seconds(cells, size) : 0;
  VisibilityWorkspace workspace;
  workspace.simd = simd;
  VisibilityResult result;
  std::size_t i = 0, views = 0;
  double voxels = 0;
  const double start = cpu_seconds();
  for (auto _ : state) {
    c.scene->evaluate(c.views[i++ % c.views.size()], kCamera, workspace, result);
    benchmark::DoNotOptimize(result.unknown_pixels);
  }
  const double seconds = (cpu_seconds() - start) / static_cast<double>(state.iterations());
  for (const Pose& X_WC : c.views) {
    c.scene->evaluate(X_WC, kCamera, {0, std::numeric_limits<double>::infinity(), 5}, workspace, result);
    voxels += static_cast<double>(result.unknown.size());
    ++views;
  }
  state.counters["N_u"] = voxels / static_cast<double>(views);
  if (octomap > 0) state.counters["times_octomap"] = octomap / seconds;
}

void evaluate_pair(benchmark::State& state) {
  const Case& c = scene_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const StereoRig rig{kCamera, 0.144};
  const PairOptions options{.depth_min = 0.6, .depth_max = state.range(1) > 100 ? 5.0 : 2.5, .more_than_pixels = 5};
  VisibilityWorkspace workspace;
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(c.scene->evaluate_pair(c.views[i++ % c.views.size()], rig, options, workspace).voxels);
}

void build_scene(benchmark::State& state) {
  const Case& c = scene_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  for (auto _ : state) {
    const VisibilityScene scene(c.object.grid, c.object.occluders, c.object.watched);
    benchmark::DoNotOptimize(&scene);
  }
}

void octomap_cast_rays(benchmark::State& state) {
  const Case& c = scene_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const octomap::OcTree tree = octree_of(c.object.grid);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(cast_all(tree, c.object.grid.geometry(), c.views[i++ % c.views.size()]));
}

void opengl_faces(benchmark::State& state) {
  const Case& c = scene_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const render::GlContext context("auto", 1);
  render::GlVisibility gl(context, c.object.grid, kCamera.width, kCamera.height);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(gl.evaluate(c.views[i++ % c.views.size()], kCamera).known);
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"cells", "cm"})->Unit(benchmark::kMillisecond)->ArgsProduct({{64, 128, 256}, {50, 200}});
}
void smaller_sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"cells", "cm"})->Unit(benchmark::kMillisecond)->ArgsProduct({{64, 128}, {50, 200}});
}
BENCHMARK_CAPTURE(evaluate, avx512_popcnt, Simd::avx512_popcnt)->Apply(sizes);
BENCHMARK_CAPTURE(evaluate, avx512, Simd::avx512)->Apply(sizes);
BENCHMARK_CAPTURE(evaluate, avx2, Simd::avx2)->Apply(sizes);
BENCHMARK_CAPTURE(evaluate, portable, Simd::portable)->Apply(sizes);
BENCHMARK(evaluate_pair)->Apply(sizes);
BENCHMARK(build_scene)->Apply(smaller_sizes);
BENCHMARK(octomap_cast_rays)->Apply(smaller_sizes)->Iterations(4);
BENCHMARK(opengl_faces)->Apply(smaller_sizes)->Iterations(10)->MeasureProcessCPUTime();

}  // namespace
}  // namespace periplus::voxel
