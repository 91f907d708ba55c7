// The search against the best of 50,000 exact evaluations, over recorded situations.
//
//   search_bench SITUATIONS --reference FILE [--make-reference] [--only NAME] [--methods plain,bobyqa,...] [--seeds N]
//                [--threads N] [--json FILE] [--detail]
//
// --make-reference: appends what FILE lacks, a situation a thread: uniform and face-directed samples, then simplex searches in
// all degrees of freedom from the best, until 50,000 pairs are evaluated. One line a situation: name, N_u, threshold [px],
// evaluations, pose (x y z [m], yaw pitch roll [rad]). A reference's pose is evaluated again before it is compared with: its
// N_u is what today's kernel says.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <map>
#include <mutex>
#include <numbers>
#include <sstream>

#include "common/core/error.h"
#include "common/core/random.h"
#include "services/nbv_planner/bench/situation_file.h"
#include "services/nbv_planner/local_search.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv::bench {
namespace {

constexpr int kReferenceEvaluations = 50000;

EvaluationSettings evaluation_of(const Situation& s) {
  EvaluationSettings e;
  // 5 pixels up to 1 cm; from there on the same share of a voxel's face.
  const double cm = s.grid->geometry().voxel_size * 100;
  e.pair.more_than_pixels = static_cast<int>(std::lround(5 * std::max(1.0, cm * cm)));
  return e;
}

struct Reference {
  int voxels = 0;              // as the file says
  std::vector<double> pose;
};

std::map<std::string, Reference> read_reference(const std::string& path) {
  std::map<std::string, Reference> all;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string name;
    Reference r;
    double threshold = 0, evaluations = 0;
    if (line.empty() || line[0] == '#' || !(words >> name >> r.voxels >> threshold >> evaluations)) continue;
    for (double v; words >> v;) r.pose.push_back(v);
    require(r.pose.size() >= 5, ErrorCode::bad_input, path + ": '" + name + "' has no pose");
    all[name] = r;
  }
  return all;
}

Pose pose_of(const std::vector<double>& x) { return look_along({x[0], x[1], x[2]}, x[3], x[4], x.size() > 5 ? x[5] : 0); }

struct Found {
  double value = 0;  // N_u
  std::vector<double> x;  // position of the left eye, yaw, pitch, roll
};

std::string make_reference(const RecordedSituation& r) {
  const Situation& s = r.situation;
  const Evaluator evaluator(s, evaluation_of(s), {});
  Evaluator::Workspace workspace;
  const robot::ViewLimits& l = s.limits;
  const voxel::GridGeometry& g = s.grid->geometry();
  const Eigen::Vector3d half = g.size.cast<double>() * g.voxel_size / 2, middle = g.X_WG * half;
  const auto faces = evaluator.visibility().unknown_faces(1);
  Random random(77);
  int evaluations = 0;
  const auto value = [&](const std::vector<double>& x) {
    const Pose X_WC = pose_of(x);
    if (evaluator.constraints().check(X_WC) != Violation::none) return -1.0;
    ++evaluations;
    return double(evaluator.evaluate(X_WC, workspace).gain.voxels);
  };
  std::vector<Found> found;
  while (evaluations < 15000) {
    const bool uniform = found.size() % 2 == 0 || faces.empty();
    Eigen::Vector3d target = middle + half.cwiseProduct(Eigen::Vector3d(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8)));
    Eigen::Vector3d from = middle;
    double distance = half.head<2>().norm() * random.uniform() + random.uniform(l.distance_min, 2.4);
    if (!uniform) {
      target = from = g.center_world(evaluator.visibility().voxel(faces[random.below(faces.size())].voxel));
      distance = random.uniform(l.distance_min, 2.4);
    }
    const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Vector3d p(from.x() + distance * std::cos(angle), from.y() + distance * std::sin(angle), random.uniform(l.height_min, l.height_max));
    const Eigen::Vector3d d = target - p;
    const double pitch = std::clamp(std::atan2(-d.z(), std::hypot(d.x(), d.y())), l.pitch_min, l.pitch_max);
    std::vector<double> x{p.x(), p.y(), p.z(), std::atan2(d.y(), d.x()), pitch};
    if (l.roll_max > 0) x.push_back(random.uniform(-l.roll_max, l.roll_max));
    const double v = value(x);
    if (v >= 0) found.push_back({v, x});
  }
  const auto sort = [](std::vector<Found>& all) {
    std::stable_sort(all.begin(), all.end(), [](const Found& a, const Found& b) { return a.value > b.value; });
  };
  const auto polish = [&](Found& from, double scale) {
    LocalSearchOptions options;
    options.method = LocalMethod::nelder_mead;
    options.step = {0.12 * scale, 0.12 * scale, 0.08 * scale, 0.08 * scale, 0.08 * scale};
    options.lower = {-10, -10, l.height_min, -10, l.pitch_min};
    options.upper = {10, 10, l.height_max, 10, l.pitch_max};
    if (l.roll_max > 0) {
      options.step.push_back(0.05 * scale);
      options.lower.push_back(-l.roll_max);
      options.upper.push_back(l.roll_max);
    }
    options.end = 1e-3 * scale;
    options.max_evaluations = 300;
    const LocalSearchResult best = minimize([&](const std::vector<double>& x) { return -value(x); }, from.x, options);
    if (-best.value > from.value) from = {-best.value, best.x};
  };
  sort(found);
  std::vector<Found> starts;
  for (const Found& f : found) {
    const bool close = std::any_of(starts.begin(), starts.end(), [&](const Found& o) {
      double d = 0;
      for (int k = 0; k < 3; ++k) d += std::pow(o.x[k] - f.x[k], 2);
      return d + std::pow(0.5 * wrap_angle(o.x[3] - f.x[3]), 2) < 0.15 * 0.15;
    });
    if (!close) starts.push_back(f);
    if (starts.size() >= 200) break;
  }
  std::vector<Found> ends;
  for (Found& f : starts) {
    if (evaluations > 42000) break;
    polish(f, 1);
    ends.push_back(f);
  }
  sort(ends);
  for (std::size_t k = 0; evaluations < kReferenceEvaluations; k = (k + 1) % std::min<std::size_t>(12, ends.size())) {
    const int before = evaluations;
    polish(ends[k], 0.4);
    if (evaluations == before) break;
  }
  sort(ends);
  const Found& best = ends.front().value >= found.front().value ? ends.front() : found.front();
  std::ostringstream out;
  out << r.name << " " << best.value << " " << evaluator.settings().pair.more_than_pixels << " " << evaluations << std::setprecision(17);
  for (double v : best.x) out << " " << v;
  return out.str();
}

void make_references(const std::vector<RecordedSituation>& situations, const std::string& only, const std::string& path, int threads) {
  const auto there = read_reference(path);
  std::ofstream out(path, std::ios::app);
  std::mutex mutex;
  std::atomic<std::size_t> next{0};
  on_threads(threads, [&](int) {
    for (std::size_t i; (i = next++) < situations.size();) {
      if (there.contains(situations[i].name) || situations[i].name.find(only) == std::string::npos) continue;
      const std::string line = make_reference(situations[i]);
      const std::lock_guard lock(mutex);
      out << line << std::endl;
      std::cout << line << std::endl;
    }
  });
}

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// "fast" or, to try other numbers, "fast:positions=60:exact=2".
void override_settings(const std::string& what, PanoramaSettings& s) {
  std::istringstream words(what);
  for (std::string word; std::getline(words, word, ':');) {
    const std::size_t at = word.find('=');
    if (at == std::string::npos) continue;
    const std::string key = word.substr(0, at);
    const double v = std::stod(word.substr(at + 1));
    const std::pair<const char*, int*> numbers[] = {
        {"positions", &s.positions}, {"rounds", &s.rounds}, {"kept", &s.kept}, {"each", &s.each}, {"wide", &s.wide}, {"starts", &s.starts},
        {"position_evaluations", &s.position_evaluations}, {"finalists", &s.finalists}, {"final_evaluations", &s.final_evaluations},
        {"much_from", &s.much_from}, {"final_rounds", &s.final_rounds}, {"exact", &s.exact}, {"exact_evaluations", &s.exact_evaluations}};
    bool known = key == "radius";
    if (known) s.radius = v;
    for (const auto& [name, number] : numbers) {
      if (key == name) {
        *number = static_cast<int>(v);
        known = true;
      }
    }
    require(known, ErrorCode::bad_input, "no setting '" + key + "'");
  }
}

SearchSettings settings_of(const std::string& text, int threads) {
  const std::string method = text.substr(0, text.find(':'));
  SearchSettings s;
  override_settings(text, s.fast);
  override_settings(text, s.thorough);
  s.threads = threads;
  s.max_evaluations = 3000;
  s.method = SearchMethod::thesis;
  if (method == "fast") {
    s.method = SearchMethod::fast;
  } else if (method == "thorough") {
    s.method = SearchMethod::thorough;
  } else if (method == "plain") {  // 300 samples, a simplex search from each of the best eight
    s.thesis.local = ThesisLocal::nelder_mead;
    s.thesis.starts = 8;
    s.thesis.first_stage_runs = s.thesis.second_stage_runs = s.thesis.finalists = 1;
    s.thesis.run_evaluations = 100;
    s.max_evaluations = 1300;
  } else if (method == "bobyqa") {
    s.thesis.local = ThesisLocal::bobyqa;
  } else if (method == "newuoa") {
    s.thesis.local = ThesisLocal::newuoa;
  } else if (method == "nelder-mead") {
    s.thesis.local = ThesisLocal::nelder_mead;
  } else if (method == "sampling") {
    s.thesis.local = ThesisLocal::none;
  } else {
    throw_error(ErrorCode::bad_input, "no method '" + method + "': plain, bobyqa, newuoa, nelder-mead, sampling, fast, thorough");
  }
  return s;
}

double quantile(std::vector<double> v, double share) {
  std::sort(v.begin(), v.end());
  return v.empty() ? 0 : v[static_cast<std::size_t>(share * static_cast<double>(v.size() - 1))];
}

struct Row {
  std::vector<double> share, cpu, wall, evaluations;
  std::map<std::string, double> stages;
};

}  // namespace
}  // namespace periplus::nbv::bench

int main(int argc, char** argv) {
  using namespace periplus;
  using namespace periplus::nbv;
  using namespace periplus::nbv::bench;
  std::string reference, only, json;
  std::vector<std::string> methods{"plain", "bobyqa", "fast", "thorough"};
  bool make = false, detail = false;
  int seeds = 1, threads = 2;
  for (int i = 2; i < argc; ++i) {
    const std::string key = argv[i];
    const auto next = [&] { return i + 1 < argc ? std::string(argv[++i]) : std::string(); };
    if (key == "--reference") reference = next();
    else if (key == "--make-reference") make = true;
    else if (key == "--detail") detail = true;
    else if (key == "--only") only = next();
    else if (key == "--json") json = next();
    else if (key == "--seeds") seeds = std::stoi(next());
    else if (key == "--threads") threads = std::stoi(next());
    else if (key == "--methods") {
      methods.clear();
      std::istringstream words(next());
      for (std::string m; std::getline(words, m, ',');) methods.push_back(m);
    }
  }
  if (argc < 2 || reference.empty()) {
    std::cerr << "usage: search_bench SITUATIONS --reference FILE [--make-reference] [--only NAME] [--methods LIST] [--seeds N] [--threads N] [--json FILE]\n";
    return 2;
  }
  try {
    const auto situations = load_situations(argv[1]);
    if (make) {
      make_references(situations, only, reference, threads);
      return 0;
    }
    const auto references = read_reference(reference);
    std::map<std::string, int> best;
    std::map<std::string, Row> rows;
    for (const auto& r : situations) {
      if (r.name.find(only) == std::string::npos) continue;
      if (const auto at = references.find(r.name); at != references.end()) {
        const Evaluator evaluator(r.situation, evaluation_of(r.situation), {});
        Evaluator::Workspace workspace;
        best[r.name] = evaluator.evaluate(pose_of(at->second.pose), workspace).gain.voxels;
        if (std::abs(best[r.name] - at->second.voxels) > 0.002 * at->second.voxels + 1) {
          std::printf("%s: the reference says %d, its pose shows %d now\n", r.name.c_str(), at->second.voxels, best[r.name]);
        }
      } else {
        std::printf("%s: no reference\n", r.name.c_str());
        best[r.name] = 0;
      }
      if (detail) std::printf("%-18s %6d of %6zu faces", r.name.c_str(), best[r.name], Evaluator(r.situation, evaluation_of(r.situation), {}).visibility().unknown_face_count());
      for (const std::string& m : methods) {
        const SearchSettings settings = settings_of(m, threads);
        for (int seed = 0; seed < seeds; ++seed) {
          const double cpu = cpu_seconds();
          const auto begin = std::chrono::steady_clock::now();
          const PlannedView view = plan_view(r.situation, static_cast<std::uint64_t>(1000 + seed), settings, evaluation_of(r.situation), {});
          const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
          Row& row = rows[m];
          row.cpu.push_back((cpu_seconds() - cpu) * 1e3);
          row.wall.push_back(wall * 1e3);
          row.evaluations.push_back(view.evaluations);
          const double share = view.evaluation.gain.voxels / static_cast<double>(std::max(1, best[r.name]));
          if (best[r.name] > 0) row.share.push_back(share);  // nothing to compare with otherwise
          for (const auto& [name, seconds] : view.seconds) row.stages[name] += seconds * 1e3;
          if (detail) {
            std::printf("  %s %.4f %.0f/%.0f ms %d", m.c_str(), share, row.cpu.back(), row.wall.back(), view.evaluations);
            for (const auto& [name, seconds] : view.seconds) std::printf(" %s=%.0f", name.c_str(), seconds * 1e3);
          }
        }
      }
      if (detail) std::printf("\n");
      std::fflush(stdout);
    }
    std::printf("%-40s %7s %7s %7s %7s | %8s %8s | %8s %8s | %6s\n", "method", "least", "p5", "median", ">=98%", "cpu p50", "cpu p95", "wall p50", "wall p95",
                "evals");
    std::ostringstream report;
    report << "{\"situations\": \"" << argv[1] << "\", \"threads\": " << threads << ", \"seeds\": " << seeds << ", \"methods\": {";
    bool first = true;
    for (const std::string& m : methods) {
      const Row& row = rows[m];
      const double good = static_cast<double>(std::count_if(row.share.begin(), row.share.end(), [](double v) { return v >= 0.98; })) / static_cast<double>(std::max<std::size_t>(1, row.share.size()));
      std::printf("%-40s %7.4f %7.4f %7.4f %6.1f%% | %8.1f %8.1f | %8.1f %8.1f | %6.0f  ", m.c_str(), quantile(row.share, 0), quantile(row.share, 0.05),
                  quantile(row.share, 0.5), 100 * good, quantile(row.cpu, 0.5), quantile(row.cpu, 0.95), quantile(row.wall, 0.5), quantile(row.wall, 0.95),
                  quantile(row.evaluations, 0.5));
      for (const auto& [name, ms] : row.stages) std::printf(" %s %.1f", name.c_str(), ms / static_cast<double>(row.cpu.size()));
      std::printf("\n");
      report << (first ? "" : ", ") << "\"" << m << "\": {\"compared\": " << row.share.size() << ", \"least\": " << quantile(row.share, 0) << ", \"p5\": " << quantile(row.share, 0.05)
             << ", \"median\": " << quantile(row.share, 0.5) << ", \"at_least_98_percent\": " << good << ", \"cpu_ms_p50\": " << quantile(row.cpu, 0.5)
             << ", \"cpu_ms_p95\": " << quantile(row.cpu, 0.95) << ", \"wall_ms_p50\": " << quantile(row.wall, 0.5) << ", \"wall_ms_p95\": "
             << quantile(row.wall, 0.95) << ", \"evaluations_p50\": " << quantile(row.evaluations, 0.5) << "}";
      first = false;
    }
    report << "}}\n";
    if (!json.empty()) std::ofstream(json) << report.str();
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "search_bench: " << e.what() << "\n";
    return 1;
  }
}
