#include "integration-tests/nbv_benchmark/benchmark.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "integration-tests/nbv_benchmark/kept.h"
#include "integration-tests/nbv_benchmark/report.h"
#include "integration-tests/nbv_benchmark/settings.h"

namespace periplus::nbv_benchmark {
namespace {

namespace fs = std::filesystem;

struct TemporaryFolder {
  fs::path path = fs::temp_directory_path() / ("nbv_benchmark_test." + std::to_string(::getpid()));
  TemporaryFolder() { fs::create_directories(path); }
  ~TemporaryFolder() { fs::remove_all(path); }
};

// An angle of two plates with a block between: it hides parts of itself.
SubjectFile angle_iron(const fs::path& folder) {
  mesh::TriangleMesh m = mesh::make_box({0.5, 0.5, 0.04}, 1);
  const auto add = [&](mesh::TriangleMesh part, const Eigen::Vector3d& p) {
    const int first = static_cast<int>(m.vertices.size());
    for (const auto& v : part.vertices) m.vertices.push_back(v + p);
    for (const Eigen::Vector3i& t : part.triangles) m.triangles.push_back(t.array() + first);
  };
  add(mesh::make_box({0.04, 0.5, 0.4}, 1), {-0.2, 0, 0.2});
  add(mesh::make_box({0.1, 0.1, 0.1}, 1), {0.1, 0.1, 0.07});
  m.corner_uv.clear();
  m.corner_normals.clear();
  mesh::write_ply(m, folder / "angle.ply");
  return {"angle", folder / "angle.ply", "z", ""};
}

BenchmarkOptions small(const SubjectFile& file) {
  BenchmarkOptions o;
  o.objects = {file};
  o.settings = {{PoseSet::dome, SensorKind::ideal, Camera::single, {"ours", "random", "oracle"}},
                {PoseSet::free, SensorKind::ideal, Camera::single, {"ours", "random", "oracle"}}};
  o.subject.voxels = 40;
  o.subject.samples = 2000;
  o.views = 4;
  o.candidates = 20;
  o.threads = 1;
  return o;
}

std::string text_of(const BenchmarkResult& r, const BenchmarkOptions& o) {
  nlohmann::json j = to_json(r, o, provenance("test"));
  without_times(j);
  return j.dump();
}

TEST(Benchmark, SameReportForOneAndTwoThreadsAndTheSameSeed) {
  const TemporaryFolder folder;
  BenchmarkOptions o = small(angle_iron(folder.path));
  const std::string one = text_of(run_benchmark(o), o);
  o.threads = 2;
  EXPECT_EQ(text_of(run_benchmark(o), o), one);
  o.seed = 2;
  EXPECT_NE(text_of(run_benchmark(o), o), one);
}

TEST(Benchmark, CoverageGrowsAndTheOracleLeads) {
  const TemporaryFolder folder;
  const BenchmarkOptions o = small(angle_iron(folder.path));
  for (const SettingResult& s : run_benchmark(o).settings) {
    const ObjectResult& object = s.objects.at(0);
    ASSERT_EQ(object.runs.size(), 3u);
    const nbv_benchmark::Run &ours = object.runs[0], &random = object.runs[1], &oracle = object.runs[2];
    for (const nbv_benchmark::Run& run : object.runs) {
      ASSERT_EQ(run.views.size(), 4u);
      EXPECT_EQ(run.views[0].candidate, ours.views[0].candidate) << "all begin alike";
      EXPECT_LT(run.error_mean, 1e-5) << "an ideal sensor measures points of the surface";
      for (std::size_t v = 1; v < 4; ++v) {
        EXPECT_GE(run.views[v].all, run.views[v - 1].all);
        EXPECT_LE(run.views[v].unknown, run.views[v - 1].unknown);
      }
    }
    // At its own measure no other second view covers more; and greedy stays ahead of chance on this object.
    for (const nbv_benchmark::Run* other : {&ours, &random}) EXPECT_GE(oracle.views[1].all, other->views[1].all);
    for (std::size_t v = 0; v < 4; ++v) EXPECT_GE(oracle.views[v].all, random.views[v].all) << s.setting.name() << " view " << v + 1;
    EXPECT_GT(oracle.views[3].visible, 0.9);
    EXPECT_GT(ours.views[3].visible, 0.85);
  }
}

TEST(Benchmark, VariantsRunWithTheirOwnParameters) {
  const TemporaryFolder folder;
  BenchmarkOptions o = small(angle_iron(folder.path));
  o.variants["same"] = o.variants["quality"] = {o.evaluation, o.search};
  // So much that a better look at what is known outweighs the unknown; it needs to be told of the looks so far.
  o.variants["quality"].evaluation.quality_weight = 100;
  o.settings = {{PoseSet::free, SensorKind::ideal, Camera::single, {"ours", "ours:same", "ours:quality"}}};
  const BenchmarkResult result = run_benchmark(o);
  const std::vector<nbv_benchmark::Run>& runs = result.settings.at(0).objects.at(0).runs;
  std::vector<int> chosen[3];
  for (int r = 0; r < 3; ++r)
    for (const ViewRecord& v : runs.at(static_cast<std::size_t>(r)).views) chosen[r].push_back(v.candidate);
  EXPECT_EQ(chosen[1], chosen[0]);
  EXPECT_NE(chosen[2], chosen[0]);
  for (const char* wrong : {"ours:other", "random:same", "ours:", "oracle:same"}) {
    o.settings[0].planners = {wrong};
    EXPECT_THROW(run_benchmark(o), Error) << wrong;
  }
}

TEST(Benchmark, KeptRunsGiveTheSameMeasuresAgain) {
  const TemporaryFolder folder;
  BenchmarkOptions o = small(angle_iron(folder.path));
  o.robot = robot::RobotModel::load_files(PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like.urdf", PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like.yaml");
  o.settings = {{PoseSet::free, SensorKind::ideal, Camera::single, {"ours"}}, {PoseSet::reachable, SensorKind::ideal, Camera::pair, {"random"}}};
  o.views = 2;
  o.keep_folder = folder.path / "kept";
  run_benchmark(o);
  const Recomputed all = recompute(o.keep_folder);
  EXPECT_EQ(all.runs, 2);
  EXPECT_EQ(all.views, 4);
  EXPECT_TRUE(all.differences.empty()) << all.differences.front();
  // A depth map that was swapped for another is found out.
  const fs::path run = folder.path / "kept/free-ideal-single/angle/ours";
  fs::copy_file(run / "view-01-left.npy.gz", run / "view-02-left.npy.gz", fs::copy_options::overwrite_existing);
  EXPECT_FALSE(recompute(o.keep_folder).differences.empty());
  std::ofstream(run / "view-02-left.npy.gz") << "no such file";
  EXPECT_THROW(recompute(o.keep_folder), Error);
  EXPECT_THROW(recompute((folder.path / "nothing").string()), Error);
}

TEST(Benchmark, TheSamePoseAgainShowsNothingNew) {
  const TemporaryFolder folder;
  const Subject subject = load_subject(angle_iron(folder.path), {.voxels = 48, .samples = 1000});
  const Arena arena = make_arena(subject, {.set = PoseSet::free, .candidates = 8, .robot = nullptr});
  object_model::CarvingSettings carving;
  carving.known_points = 1;
  carving.seen_points = 3;
  Reconstruction model(arena, subject, carving);
  nbv::EvaluationSettings evaluation;
  evaluation.pair.more_than_pixels = 0;
  const auto sensor = make_sensor(SensorKind::ideal, arena, subject, 1);
  const auto promised = [&](const Pose& X) {
    const nbv::Situation s = situation_of(arena, std::make_shared<voxel::OccupancyGrid>(model.grid()));
    nbv::Evaluator::Workspace workspace;
    return nbv::Evaluator(s, evaluation, {}).evaluate(X, workspace).gain.voxels;
  };
  for (const Pose& X : {arena.candidates[0], arena.candidates[3]}) {
    const int before = promised(X);
    model.integrate(sensor->look(X, 0));
    // What stays are voxels on the outline, which no single view can empty.
    EXPECT_LT(promised(X), 0.25 * before);
  }
}

// A slat seen face on: its shadow shows most from the side, where next to nothing of the slat is to be seen.
TEST(Benchmark, TheBackOfASlatComesNextAndNotTheSideOfItsShadow) {
  const Subject subject = make_subject("slat", mesh::make_box({0.1, 0.5, 0.02}, 1), "z", {.voxels = 128, .samples = 4000});
  Arena arena = make_arena(subject, {.set = PoseSet::free, .candidates = 1, .robot = nullptr});
  const Eigen::Vector3d middle = arena.X_WO.translation();
  const auto from = [&](double x, double z) { return look_at(middle + Eigen::Vector3d(x, 0.02, z), middle); };
  const Pose front = from(0.02, 1);
  const std::vector<Pose> side_and_behind = {from(1, -0.02), from(0.02, -1)};
  object_model::CarvingSettings carving;
  carving.known_points = 1;
  carving.seen_points = 3;
  Reconstruction model(arena, subject, carving);
  const auto sensor = make_sensor(SensorKind::ideal, arena, subject, 1);
  model.integrate(sensor->look(front, 0));
  nbv::EvaluationSettings evaluation;
  evaluation.pair.more_than_pixels = 0;
  const auto chosen = [&](int likely_within) {
    evaluation.likely_within = likely_within;
    const nbv::Situation s = situation_of(arena, std::make_shared<voxel::OccupancyGrid>(model.grid()));
    nbv::Evaluator::Workspace workspace;
    return nbv::choose_view(nbv::Evaluator(s, evaluation, {}), side_and_behind, workspace).index;
  };
  EXPECT_EQ(chosen(0), 0) << "all that is unknown";
  const config::Node shipped = config::load_file(PERIPLUS_SOURCE_DIR "/integration-tests/nbv_benchmark/config/default.yaml");
  EXPECT_EQ(chosen(shipped.child("planner").child("evaluation").get<int>("likely_within_voxels")), 1);
}

TEST(Benchmark, BadMeshesAndFoldersAreNamed) {
  const TemporaryFolder folder;
  const auto message = [](auto call) -> std::string {
    try {
      call();
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(message([&] { mesh_folder((folder.path / "none").string(), "y"); }).find("there is no folder"), std::string::npos);
  EXPECT_NE(message([&] { mesh_folder(folder.path.string(), "y"); }).find("holds no mesh"), std::string::npos);
  std::ofstream(folder.path / "broken.off") << "OFF\n3 1 0\n0 0 0\n1 0\n";
  ASSERT_EQ(mesh_folder(folder.path.string(), "y").size(), 1u);
  BenchmarkOptions o = small(mesh_folder(folder.path.string(), "y").front());
  EXPECT_NE(message([&] { run_benchmark(o); }).find("broken.off"), std::string::npos);
  o.settings[0].planners = {"ours", "clairvoyant"};
  EXPECT_NE(message([&] { run_benchmark(o); }).find("clairvoyant"), std::string::npos);
  // A robot is needed for its poses.
  o = small(angle_iron(folder.path));
  o.settings[0].set = PoseSet::reachable;
  EXPECT_NE(message([&] { run_benchmark(o); }).find("--robot"), std::string::npos);
  EXPECT_NE(message([&] { read_options(config::parse("settings: [{poses: free, sensor: stereo, camera: single, planners: [ours]}]", "x.yaml")); })
                .find("stereo needs camera: pair"),
            std::string::npos);
  EXPECT_NE(message([&] { read_options(config::parse("vews: 3", "x.yaml")); }).find("views"), std::string::npos);
}

}  // namespace
}  // namespace periplus::nbv_benchmark
