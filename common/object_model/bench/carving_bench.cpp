// A depth map of 640x480 into a grid of 0.5 m around a sphere before a wall, one of 0.3 m or one that fills its box as an object does, and beside
// it Algorithm 3 voxel by voxel and OctoMap's insertPointCloud (maxrange -1, lazy_eval true, discretize true, limited to the box) of the same depth. Limited to the box, OctoMap follows
// only the rays that end in it: those to the wall, which empty the rest of the box for ours, cost it nothing and tell it nothing.
// Without any limit it takes minutes and 14 GB; limited instead to rays as long as the way to the box's farthest corner, it empties the same
// space as ours and what lies before the box (octomap_whole_space). `times_octomap`: how often ours fits into OctoMap's time in this run,
// limited to the box; `times_octomap_whole_space` likewise. Each turn begins with the grid as the first look left it: the work of a second look.
#include <benchmark/benchmark.h>
#include <malloc.h>
#include <octomap/octomap.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <tuple>

#include "common/object_model/evidence.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/voxel/visibility.h"

namespace periplus::object_model {
namespace {

struct Case {
  voxel::OccupancyGrid grid{voxel::GridGeometry::from_box(Pose::Identity(), {0.1, 0.1, 0.1}, 0.1)};
  Evidence evidence;
  std::vector<std::uint64_t> environment;
  DepthMap map;
  PixelLimits limits;
};

double wall_seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

constexpr int kSmall = 30, kFilling = 45;  // diameter [cm]

const Case& case_of(int cells, int diameter_cm = kSmall) {
  static std::map<std::pair<int, int>, Case> cases;
  const auto [at, is_new] = cases.try_emplace({cells, diameter_cm});
  Case& c = at->second;
  if (is_new) {
    const testing::Sphere sphere{.radius = diameter_cm / 200.0};
    const ObjectBox box = testing::box_around(sphere);
    c.grid = voxel::OccupancyGrid(voxel::GridGeometry::from_box(box.X_WB, box.size, 0.5 / cells));
    c.evidence = Evidence(c.grid.geometry());
    c.environment.assign(c.grid.occupied().size(), 0);
    for (const int n : {0, 1}) {
      c.map = testing::ideal_view(sphere, n, 6, 640, 480).depth[0];
      c.limits = pixel_limits(c.map, c.grid.geometry(), {}, true, nullptr);
      if (n == 0) empty_voxels(seen_through(c.grid, c.map.camera, c.map.X_WC, c.limits.limit, CarvingSettings{}.margin_voxels), 1, c.grid, c.evidence);
    }
  }
  return c;
}

octomap::point3d point(const Eigen::Vector3d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())}; }

enum class Limit { box, longest_ray };

void insert(const Case& c, Limit limit, octomap::OcTree& tree) {
  const voxel::GridGeometry& g = c.grid.geometry();
  double longest = -1;
  if (limit == Limit::box) {
    octomap::point3d lower = point(g.X_WG.translation()), upper = point(g.X_WG * (g.size.cast<double>() * g.voxel_size).eval());
    tree.useBBXLimit(true);
    tree.setBBXMin(lower);
    tree.setBBXMax(upper);
  } else {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p_G = g.size.cast<double>().cwiseProduct(Eigen::Vector3d(corner & 1, corner >> 1 & 1, corner >> 2)) * g.voxel_size;
      longest = std::max(longest, (g.X_WG * p_G - c.map.X_WC.translation()).norm());
    }
  }
  octomap::Pointcloud cloud;
  for (int v = 0; v < c.map.depth.height; ++v) {
    for (int u = 0; u < c.map.depth.width; ++u) cloud.push_back(point(c.map.X_WC * c.map.camera.back_project(u, v, c.map.depth.at(u, v))));
  }
  tree.insertPointCloud(cloud, point(c.map.X_WC.translation()), longest, true, true);
}

// Time of one insertion [s]; once a run for each grid.
double octomap_seconds(int cells, int diameter_cm, Limit limit) {
  static std::map<std::tuple<int, int, Limit>, double> known;
  const auto [at, is_new] = known.try_emplace({cells, diameter_cm, limit}, 0.0);
  if (is_new) {
    const Case& c = case_of(cells, diameter_cm);
    octomap::OcTree tree(c.grid.geometry().voxel_size);
    const double start = wall_seconds();
    insert(c, limit, tree);
    at->second = wall_seconds() - start;
  }
  return at->second;
}

// Limits, carving and points: all that the grid takes from a depth map, on two threads as the model does it; wall time.
void depth_into_grid(benchmark::State& state) {
  const int cells = static_cast<int>(state.range(0)), diameter_cm = static_cast<int>(state.range(1));
  const Case& c = case_of(cells, diameter_cm);
  const double octomap = octomap_seconds(cells, diameter_cm, Limit::box), whole = cells <= 128 ? octomap_seconds(cells, diameter_cm, Limit::longest_ray) : 0;
  double seconds = 0;
  for (auto _ : state) {
    state.PauseTiming();
    voxel::OccupancyGrid grid = c.grid;
    Evidence evidence = c.evidence;
    state.ResumeTiming();
    const double start = wall_seconds();
    const PixelLimits limits = pixel_limits(c.map, grid.geometry(), {}, true, nullptr);
    carve_and_count(c.map, limits, CarvingSettings{}.margin_voxels, 1, grid, evidence);
    seconds += wall_seconds() - start;
    benchmark::DoNotOptimize(grid.occupied().data());
  }
  state.counters["times_octomap"] = octomap * static_cast<double>(state.iterations()) / seconds;
  if (whole > 0) state.counters["times_octomap_whole_space"] = whole * static_cast<double>(state.iterations()) / seconds;
}

void carving_alone(benchmark::State& state, voxel::Simd simd) {
  if (!voxel::has_simd(simd)) return state.SkipWithError("this processor has no such instructions");
  const Case& c = case_of(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(seen_through(c.grid, c.map.camera, c.map.X_WC, c.limits.limit, CarvingSettings{}.margin_voxels, simd));
}

void limits_alone(benchmark::State& state) {
  const Case& c = case_of(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(pixel_limits(c.map, c.grid.geometry(), {}, true, nullptr));
}

void points_alone(benchmark::State& state) {
  const Case& c = case_of(static_cast<int>(state.range(0)));
  Evidence evidence = c.evidence;
  for (auto _ : state) add_points(c.map, c.limits, c.grid.geometry(), CarvingSettings{}.margin_voxels, evidence);
}

void labels(benchmark::State& state) {
  const Case& c = case_of(static_cast<int>(state.range(0)));
  voxel::OccupancyGrid grid = c.grid;
  for (auto _ : state) label(c.environment, {}, c.evidence, grid);
}

// Labels, and the surface's exposed faces with all that a search for views reads of them.
void labels_and_surface(benchmark::State& state) {
  const Case& c = case_of(static_cast<int>(state.range(0)));
  voxel::OccupancyGrid grid = c.grid;
  for (auto _ : state) {
    label(c.environment, {}, c.evidence, grid);
    const voxel::VisibilityScene scene(grid);
    benchmark::DoNotOptimize(&scene);
  }
}

// The same after a second look, from what is kept of the first: only what the look has changed is made anew. `times_anew`: how often it fits
// into the time that making all anew of the same grid takes in this run.
void labels_and_surface_kept(benchmark::State& state) {
  const Case& c = case_of(static_cast<int>(state.range(0)));
  const auto faces_before = std::make_shared<const voxel::ExposedFaces>(c.grid);
  const voxel::VisibilityScene before(faces_before);
  voxel::OccupancyGrid carved = c.grid;
  Evidence evidence = c.evidence;
  voxel::BrickMarks carving(faces_before->brick_count());
  carve_and_count(c.map, c.limits, CarvingSettings{}.margin_voxels, 1, carved, evidence, &carving);
  double kept_s = 0, anew_s = 0;
  for (auto _ : state) {
    state.PauseTiming();
    voxel::OccupancyGrid grid = carved;
    double start = wall_seconds();
    label(c.environment, {}, evidence, grid);
    benchmark::DoNotOptimize(voxel::VisibilityScene(grid));
    anew_s += wall_seconds() - start;
    grid = carved;
    voxel::BrickMarks changed = carving;
    state.ResumeTiming();
    start = wall_seconds();
    label(c.environment, {}, evidence, grid, &changed);
    auto faces = std::make_shared<voxel::ExposedFaces>(*faces_before);
    faces->update(grid, changed);
    const voxel::VisibilityScene scene(std::move(faces), {}, {}, &before);
    kept_s += wall_seconds() - start;
    benchmark::DoNotOptimize(&scene);
  }
  state.counters["times_anew"] = anew_s / kept_s;
}

// Algorithm 3 to the letter.
void naive(benchmark::State& state) {
  const Case& c = case_of(static_cast<int>(state.range(0)));
  const voxel::GridGeometry& g = c.grid.geometry();
  const Pose X_CG = c.map.X_WC.inverse() * g.X_WG;
  for (auto _ : state) {
    std::size_t emptied = 0;
    testing::for_each_voxel(g, [&](const Eigen::Vector3i& voxel) {
      if (c.grid.state(voxel) == voxel::VoxelState::empty) return;
      double u0 = 1e9, u1 = -1e9, v0 = 1e9, v1 = -1e9;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector2d q = c.map.camera.project(X_CG * ((voxel.cast<double>() + Eigen::Vector3d(corner & 1, corner >> 1 & 1, corner >> 2)) * g.voxel_size));
        u0 = std::min(u0, q.x());
        u1 = std::max(u1, q.x());
        v0 = std::min(v0, q.y());
        v1 = std::max(v1, q.y());
      }
      const double least = (X_CG * ((voxel.cast<double>().array() + 0.5) * g.voxel_size).matrix()).z() + CarvingSettings{}.margin_voxels * g.voxel_size;
      for (int y = static_cast<int>(std::floor(v0 + 0.5)); y <= static_cast<int>(std::floor(v1 + 0.5)); ++y) {
        for (int x = static_cast<int>(std::floor(u0 + 0.5)); x <= static_cast<int>(std::floor(u1 + 0.5)); ++x) {
          if (x < 0 || y < 0 || x >= c.map.camera.width || y >= c.map.camera.height || !(c.limits.limit.at(x, y) > least)) return;
        }
      }
      ++emptied;
    });
    benchmark::DoNotOptimize(emptied);
  }
}

void octomap(benchmark::State& state, Limit limit) {
  const Case& c = case_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  for (auto _ : state) {
    octomap::OcTree tree(c.grid.geometry().voxel_size);
    insert(c, limit, tree);
    benchmark::DoNotOptimize(tree.size());
  }
}

// An entry of the process' status: VmRSS, what it has in memory; VmHWM, the most it has had.
double status_mb(const std::string& entry) {
  std::ifstream status("/proc/self/status");
  std::string word;
  double kilobytes = 0;
  while (status >> word && word != entry + ":") {
  }
  status >> kilobytes;
  return kilobytes * 1024 / 1e6;
}

// What a model adds to the process: begun, and with six views of a sphere of 0.3 of its box (`views_mb` of it are pictures and depth maps, kept of
// each view whatever the grid), and the most it took meanwhile; beside it what evidence and signed distances of every voxel would take.
void memory(benchmark::State& state) {
  const int cells = static_cast<int>(state.range(0));
  const testing::Sphere sphere;
  for (auto _ : state) {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << 5;  // VmHWM begins anew
    const double before = status_mb("VmRSS");
    ObjectModel model("sphere", testing::box_around(sphere), 0.5 / cells, {});
    state.counters["begun_mb"] = status_mb("VmRSS") - before;
    double views = 0, slowest = 0;
    for (int n = 0; n < 6; ++n) {
      const Perception p = testing::ideal_view(sphere, n, 6, 640, 480);
      const double start = wall_seconds();
      model.integrate(p, {}, {});
      slowest = std::max(slowest, wall_seconds() - start);
      const View& v = *model.state().views.back();
      views += static_cast<double>(v.color.data.size());
      for (const StoredDepth& d : v.depth) views += 2.0 * static_cast<double>(d.depth.data.size() + d.minimum.data.size());
    }
    state.counters["most_mb"] = status_mb("VmHWM") - before;
    malloc_trim(0);
    state.counters["six_views_mb"] = status_mb("VmRSS") - before;
    state.counters["views_mb"] = views / 1e6;
    state.counters["slowest_view_s"] = slowest;
    state.counters["every_voxel_mb"] = std::pow(cells, 3) * (7 + sizeof(TsdfSample)) / 1e6;
    state.counters["evidence_bricks"] = static_cast<double>(model.state().evidence.bricks().held());
    state.counters["tsdf_bricks"] = static_cast<double>(model.state().tsdf.bricks().held());
  }
}

BENCHMARK(depth_into_grid)->ArgNames({"cells", "sphere_cm"})->ArgsProduct({{64, 128, 256}, {kSmall, kFilling}})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(carving_alone, avx512, voxel::Simd::avx512)->ArgName("cells")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(carving_alone, avx2, voxel::Simd::avx2)->ArgName("cells")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(carving_alone, portable, voxel::Simd::portable)->ArgName("cells")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK(limits_alone)->ArgName("cells")->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK(points_alone)->ArgName("cells")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK(labels)->ArgName("cells")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK(labels_and_surface)->ArgName("cells")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK(labels_and_surface_kept)->ArgName("cells")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK(naive)->ArgName("cells")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK(memory)->ArgName("cells")->Arg(128)->Arg(256)->Arg(512)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(octomap, insert_point_cloud, Limit::box)->ArgNames({"cells", "sphere_cm"})->ArgsProduct({{128, 256}, {kSmall, kFilling}})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(octomap, whole_space, Limit::longest_ray)->ArgNames({"cells", "sphere_cm"})->ArgsProduct({{64, 128}, {kSmall, kFilling}})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace periplus::object_model
