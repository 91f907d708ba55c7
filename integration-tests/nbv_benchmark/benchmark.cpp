#include "integration-tests/nbv_benchmark/benchmark.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>
#include <thread>

#include "common/core/error.h"
#include "integration-tests/nbv_benchmark/kept.h"

namespace periplus::nbv_benchmark {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Of this thread on a processor: what a plan costs, however many others want the machine.
double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Tasks 0 .. count-1, each on one of `threads` threads; what a task does depends on its number alone. The first task's error counts.
void in_parallel(int count, int threads, const std::function<void(int)>& task) {
  std::atomic<int> next = 0;
  std::vector<std::exception_ptr> errors(static_cast<std::size_t>(count));
  std::atomic<bool> failed = false;
  const auto work = [&] {
    for (int i = next++; i < count && !failed; i = next++) {
      try {
        task(i);
      } catch (...) {
        errors[static_cast<std::size_t>(i)] = std::current_exception();
        failed = true;
      }
    }
  };
  std::vector<std::jthread> others;
  for (int t = 1; t < std::min(threads, count); ++t) others.emplace_back(work);
  work();
  others.clear();
  for (const auto& e : errors)
    if (e) std::rethrow_exception(e);
}

std::uint64_t mix(std::uint64_t seed, std::uint64_t salt) { return Random(seed * 0x9e3779b97f4a7c15ULL + salt).next(); }

// One object in one setting: what all its planners share, and the planners one after the other.
class Explorer {
 public:
  Explorer(const BenchmarkOptions& options, const Setting& setting, const Subject& subject, const Arena& arena, const Mask& reachable)
      : o_(options), setting_(setting), subject_(subject), arena_(arena), reachable_(reachable), everything_(subject.samples.size()),
        every_voxel_(subject.voxel_points.size()), resolution_(setting.camera == Camera::single ? options.single : options.pair), sensor_(make_sensor(setting.sensor, arena, subject, options.seed)),
        kept_(options.keep_folder, setting.name(), subject, arena, reachable, options.distance) {
    carving_.known_points = resolution_.known_points;
    carving_.seen_points = resolution_.seen_points;
    for (std::size_t i = 0; i < everything_.size(); ++i) everything_.set(i);
    for (std::size_t i = 0; i < every_voxel_.size(); ++i) every_voxel_.set(i);
    if (std::any_of(setting.planners.begin(), setting.planners.end(), knows_the_object)) {
      const auto ideal = make_sensor(SensorKind::ideal, arena, subject, options.seed);
      for (const Pose& X_WC : arena.candidates) {
        Mask m(subject.samples.size());
        cover(ideal->look(X_WC, 0), m);
        covers_.push_back(std::move(m));
      }
    }
  }

  Run run(const std::string& name) {
    Run run;
    run.object = subject_.file.name;
    run.planner = name;
    const PlannerSettings planner_settings = settings_of(name);
    const auto planner = make_planner(name, planner_settings);
    Reconstruction model(arena_, subject_, carving_);
    Mask covered(subject_.samples.size());
    std::set<int> used;
    std::vector<Pose> taken;
    std::vector<double> errors;
    double travel = 0;
    for (int view = 0; view < o_.views; ++view) {
      ViewRecord record;
      Choice choice;
      if (view == 0) {
        // The same for every planner.
        choice.candidate = static_cast<int>(mix(o_.seed, 5) % arena_.candidates.size());
        choice.X_WC = first_view(choice.candidate);
      } else {
        const double start = thread_seconds();
        nbv::Situation situation = situation_of(arena_, std::make_shared<voxel::OccupancyGrid>(model.grid()));
        situation.views = taken;
        const nbv::Evaluator evaluator(situation, planner_settings.evaluation, {});
        std::vector<int> eligible;
        for (int i = 0; i < static_cast<int>(arena_.candidates.size()); ++i) {
          if (used.contains(i)) continue;
          if (arena_.set != PoseSet::dome && evaluator.constraints().check(arena_.candidates[static_cast<std::size_t>(i)]) != nbv::Violation::none) continue;
          eligible.push_back(i);
        }
        if (eligible.empty()) break;
        choice = planner->choose({arena_, situation, evaluator, eligible, covers_, covered, taken, o_.views - view});
        record.plan_seconds = thread_seconds() - start;
      }
      record.candidate = choice.candidate;
      record.predicted = choice.predicted;
      if (choice.candidate >= 0) used.insert(choice.candidate);
      if (!taken.empty()) travel += (choice.X_WC.translation() - taken.back().translation()).norm();
      taken.push_back(choice.X_WC);
      record.travel = travel;
      record.X_OC = arena_.X_WO.inverse() * choice.X_WC;

      double start = thread_seconds();
      const Look look = sensor_->look(choice.X_WC, view);
      record.look_seconds = thread_seconds() - start;
      start = thread_seconds();
      model.integrate(look);
      record.model_seconds = thread_seconds() - start;
      cover(look, covered);
      add_errors(look, errors);
      kept_.add_look(name, view, look);

      const Mask known = model.known(subject_);
      record.all = share(covered, everything_);
      record.visible = share(covered, arena_.visible);
      record.reachable = share(covered, reachable_);
      record.voxels_all = share(known, every_voxel_);
      record.voxels_visible = share(known, arena_.visible_voxels);
      record.unknown = static_cast<double>(model.grid().counts().unknown);
      run.views.push_back(record);
      if (!o_.record_folder.empty() && !knows_the_object(name) && view + 1 < o_.views) record_situation(model, name, view + 1);
    }
    if (!errors.empty()) {
      std::sort(errors.begin(), errors.end());
      double sum = 0;
      for (const double e : errors) sum += e;
      run.error_mean = sum / static_cast<double>(errors.size());
      run.error_p95 = errors[errors.size() * 95 / 100];
    }
    kept_.finish(name, run.views);
    return run;
  }

 private:
  PlannerSettings settings_of(const std::string& planner) const {
    const std::string variant = variant_of(planner);
    PlannerSettings s{variant.empty() ? o_.search : o_.variants.at(variant).search, variant.empty() ? o_.evaluation : o_.variants.at(variant).evaluation,
                      o_.gain, mix(o_.seed, 77)};
    s.evaluation.pair.more_than_pixels = resolution_.more_than_pixels;
    s.search.threads = 1;  // the objects take the others
    return s;
  }

  // The set's poses are valid beside the true object; the first one must be beside the whole box too, of which nothing is known.
  Pose first_view(int& candidate) const {
    if (arena_.set == PoseSet::dome) return arena_.candidates[static_cast<std::size_t>(candidate)];
    const Reconstruction nothing(arena_, subject_, carving_);
    const nbv::Situation situation = situation_of(arena_, std::make_shared<voxel::OccupancyGrid>(nothing.grid()));
    const voxel::VisibilityScene visibility(*situation.grid);
    const nbv::Constraints constraints(situation, visibility, {});
    const int n = static_cast<int>(arena_.candidates.size());
    for (int k = 0; k < n; ++k) {
      const int i = (candidate + k) % n;
      if (constraints.check(arena_.candidates[static_cast<std::size_t>(i)]) != nbv::Violation::none) continue;
      candidate = i;
      return arena_.candidates[static_cast<std::size_t>(i)];
    }
    throw_error(ErrorCode::bad_input, subject_.file.name + ": no pose of the set satisfies the constraints beside the whole box");
  }

  void cover(const Look& look, Mask& covered) const {
    for (const object_model::DepthMap& map : look.depth)
      add_covered(subject_.samples, without_table(arena_, map), map.camera, arena_.X_WO.inverse() * map.X_WC, o_.distance, covered);
  }

  // Distance of every so many points within the box to the true surface; what lies on the table is the table's.
  void add_errors(const Look& look, std::vector<double>& errors) const {
    constexpr int step = 7;
    const Eigen::Vector3d half = arena_.box.size / 2;
    for (const object_model::DepthMap& map : look.depth) {
      const ImageF depth = without_table(arena_, map);
      for (int v = 0; v < map.camera.height; v += step)
        for (int u = 0; u < map.camera.width; u += step) {
          const double z = depth.at(u, v);
          if (!(z > 0)) continue;
          const Eigen::Vector3d p_W = map.X_WC * map.camera.back_project(u, v, z);
          if (((arena_.box.X_WB.inverse() * p_W).cwiseAbs().array() > half.array()).any()) continue;
          errors.push_back(subject_.tree->closest(arena_.X_WO.inverse() * p_W).distance);
        }
    }
  }

  void record_situation(const Reconstruction& model, const std::string& planner, int before_view) const {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(o_.record_folder) / setting_.name() / subject_.file.name / planner;
    fs::create_directories(folder);
    const fs::path path = folder / ("before-" + std::to_string(before_view + 1) + ".periplus");
    std::ofstream file(path, std::ios::binary);
    file << model.model_file(subject_.file.name);
    file.close();
    require(file.good(), ErrorCode::io, "cannot write " + path.string());
  }

  const BenchmarkOptions& o_;
  const Setting& setting_;
  const Subject& subject_;
  const Arena& arena_;
  const Mask& reachable_;
  Mask everything_, every_voxel_;
  const BenchmarkOptions::Resolution& resolution_;
  object_model::CarvingSettings carving_;
  std::unique_ptr<Sensor> sensor_;
  KeptObject kept_;
  std::vector<Mask> covers_;
};

bool planner_has_parameters(const std::string& planner) { return base_of(planner) == "ours" || base_of(planner) == "search"; }

}  // namespace

std::string Setting::name() const { return std::string(to_string(set)) + "/" + to_string(sensor) + "/" + to_string(camera); }

BenchmarkResult run_benchmark(const BenchmarkOptions& o, const std::function<void(const std::string&)>& progress) {
  require(!o.objects.empty() && !o.settings.empty(), ErrorCode::bad_input, "a benchmark needs at least one object and one setting");
  require(o.views >= 1 && o.views <= 1000 && o.threads >= 1 && o.threads <= 256, ErrorCode::bad_input, "views must lie in 1..1000, threads in 1..256");
  require(std::isfinite(o.distance) && o.distance > 0, ErrorCode::bad_input, "the distance of coverage must be greater than 0");
  for (const Setting& s : o.settings)
    for (const std::string& planner : s.planners) {
      make_planner(planner, {});
      const std::string variant = variant_of(planner);
      require(base_of(planner) == planner || (planner_has_parameters(planner) && o.variants.contains(variant)), ErrorCode::bad_input,
              "the planner '" + planner + "' names no variant of ours or search; config/default.yaml says how variants are given");
      require(s.set != PoseSet::dome || takes_lists(planner), ErrorCode::bad_input, "the planner '" + planner + "' does not choose from a list: not for the dome");
    }
  const auto start = Clock::now();
  std::mutex mutex;
  const auto say = [&](const std::string& sentence) {
    const std::lock_guard lock(mutex);
    if (progress) progress(sentence);
  };

  const int objects = static_cast<int>(o.objects.size()), settings = static_cast<int>(o.settings.size());
  // First the objects, with what the robot can reach of them; then each in each setting.
  std::vector<Subject> subjects(o.objects.size());
  std::vector<Mask> reachable(o.objects.size());
  in_parallel(objects, o.threads, [&](int i) {
    subjects[i] = load_subject(o.objects[i], o.subject);
    reachable[i] = Mask(subjects[i].samples.size());
    if (o.robot)
      reachable[i] = make_arena(subjects[i], {.set = PoseSet::reachable, .camera = Camera::pair, .candidates = o.candidates, .seed = o.seed, .robot = o.robot}).visible;
  });

  BenchmarkResult result;
  for (const Setting& s : o.settings) result.settings.push_back({s, std::vector<ObjectResult>(o.objects.size())});
  in_parallel(objects * settings, o.threads, [&](int task) {
    const auto began = Clock::now();
    const int s = task / objects, i = task % objects;
    const Setting& setting = o.settings[s];
    const Subject& subject = subjects[i];
    const Arena arena = make_arena(subject, {.set = setting.set, .camera = setting.camera, .candidates = o.candidates, .seed = o.seed, .robot = o.robot});
    ObjectResult& out = result.settings[s].objects[i];
    out.object = subject.file.name;
    out.sha256 = subject.sha256;
    out.triangles = subject.mesh.triangles.size();
    out.samples = subject.samples.size();
    out.voxels = subject.voxel_points.size();
    out.candidates = static_cast<int>(arena.candidates.size());
    out.visible_share = static_cast<double>(arena.visible.count()) / static_cast<double>(subject.samples.size());
    out.reachable_share = static_cast<double>(reachable[i].count()) / static_cast<double>(subject.samples.size());
    Explorer explorer(o, setting, subject, arena, reachable[i]);
    for (const std::string& planner : setting.planners) out.runs.push_back(explorer.run(planner));
    char text[200];
    std::snprintf(text, sizeof text, "%s, %s: %.1f s", setting.name().c_str(), subject.file.name.c_str(), seconds_since(began));
    say(text);
  });
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace periplus::nbv_benchmark
