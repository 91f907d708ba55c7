#include "integration-tests/nbv_benchmark/report.h"

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>
#include <thread>

#include "common/core/version.h"
#include "common/voxel/visibility.h"
#include "integration-tests/nbv_benchmark/measures.h"

namespace periplus::nbv_benchmark {
namespace {

using nlohmann::json;

std::string level_key(double level) { return std::to_string(std::lround(100 * level)); }

json pose_rows(const Pose& X) {
  json rows = json::array();
  for (int r = 0; r < 3; ++r) rows.push_back({X.matrix()(r, 0), X.matrix()(r, 1), X.matrix()(r, 2), X.matrix()(r, 3)});
  return rows;
}

template <class Value>
std::vector<double> curve(const Run& run, Value value) {
  std::vector<double> out;
  for (const ViewRecord& v : run.views) out.push_back(value(v));
  return out;
}

json run_json(const Run& run, const ObjectResult& object) {
  json j = {{"planner", run.planner}};
  const auto add = [&](const char* name, auto value) {
    const std::vector<double> c = curve(run, value);
    j["coverage"][name] = c;
    j["auc"][name] = area_under(c);
    for (const double level : kLevels) {
      std::vector<std::vector<double>> all;
      for (const Run& r : object.runs) all.push_back(curve(r, value));
      const std::string key = level_key(level);
      const std::string text = views_to_text(c, all, level);
      if (const auto n = views_to(c, level))
        j["views_to"][name][key] = *n;
      else
        j["views_to"][name][key] = text;
    }
  };
  add("all", [](const ViewRecord& v) { return v.all; });
  add("visible", [](const ViewRecord& v) { return v.visible; });
  add("reachable", [](const ViewRecord& v) { return v.reachable; });
  add("voxels_all", [](const ViewRecord& v) { return v.voxels_all; });
  add("voxels_visible", [](const ViewRecord& v) { return v.voxels_visible; });
  j["unknown_voxels"] = curve(run, [](const ViewRecord& v) { return v.unknown; });
  j["predicted"] = curve(run, [](const ViewRecord& v) { return v.predicted; });
  j["travel_m"] = curve(run, [](const ViewRecord& v) { return v.travel; });
  j["surface_error_m"] = {{"mean", run.error_mean}, {"p95", run.error_p95}};
  for (const ViewRecord& v : run.views) {
    j["candidates"].push_back(v.candidate);
    j["poses_object_camera"].push_back(pose_rows(v.X_OC));
  }
  j["seconds"] = {{"plan", curve(run, [](const ViewRecord& v) { return v.plan_seconds; })},
                  {"look", curve(run, [](const ViewRecord& v) { return v.look_seconds; })},
                  {"model", curve(run, [](const ViewRecord& v) { return v.model_seconds; })}};
  return j;
}

// Over the objects: what a table of the setting shows.
json summary_json(const SettingResult& s, std::size_t planner) {
  std::vector<double> auc, last, last_all, travel, plan, error;
  json views;
  for (const double level : kLevels) views[level_key(level)] = {{"objects", 0}, {"mean", 0.0}};
  for (const ObjectResult& o : s.objects) {
    const Run& run = o.runs[planner];
    const std::vector<double> c = curve(run, [](const ViewRecord& v) { return v.visible; });
    auc.push_back(area_under(c));
    last.push_back(c.back());
    last_all.push_back(run.views.back().all);
    travel.push_back(run.views.back().travel);
    error.push_back(run.error_mean);
    for (std::size_t v = 1; v < run.views.size(); ++v) plan.push_back(run.views[v].plan_seconds);
    for (const double level : kLevels) {
      const auto n = views_to(c, level);
      json& at = views[level_key(level)];
      at["objects"] = at["objects"].get<int>() + (n ? 1 : 0);
      // An object on which the level was not reached counts as one view more than were made.
      at["mean"] = at["mean"].get<double>() + double(n ? *n : static_cast<int>(c.size()) + 1) / double(s.objects.size());
    }
  }
  return {{"planner", s.setting.planners[planner]},
          {"auc_visible_mean", mean(auc)},
          {"coverage_visible_mean", mean(last)},
          {"coverage_visible_worst", *std::min_element(last.begin(), last.end())},
          {"coverage_all_mean", mean(last_all)},
          {"views_to_visible", views},
          {"travel_m_mean", mean(travel)},
          {"surface_error_m_mean", mean(error)},
          {"seconds", {{"plan_mean", mean(plan)}}}};
}

}  // namespace

Provenance provenance(const std::string& command) {
  Provenance p;
  p.version = version();
  const char* commit = std::getenv("PERIPLUS_COMMIT");
  p.commit = commit != nullptr && *commit != 0 ? commit : "unknown";
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&now, &utc);
  char date[32];
  std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S+00:00", &utc);
  p.date = date;
  std::ifstream cpus("/proc/cpuinfo");
  std::string model = "unknown processor";
  for (std::string line; std::getline(cpus, line);)
    if (line.starts_with("model name")) {
      model = line.substr(line.find(':') + 2);
      break;
    }
  p.machine = std::to_string(std::thread::hardware_concurrency()) + " x " + model;
  p.compiler = "g++ " __VERSION__;
  p.libraries = "Eigen " + std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
                std::to_string(EIGEN_MINOR_VERSION) + ", OpenCV " CV_VERSION;
  p.simd = voxel::has_simd(voxel::Simd::avx512) ? "AVX-512" : voxel::has_simd(voxel::Simd::avx2) ? "AVX2" : "portable";
  p.command = command;
  return p;
}

json to_json(const BenchmarkResult& result, const BenchmarkOptions& o, const Provenance& made) {
  json j;
  j["schema"] = "periplus-nbv-benchmark-1";
  j["made"] = {{"version", made.version}, {"commit", made.commit}, {"date", made.date}, {"machine", made.machine}, {"compiler", made.compiler},
               {"libraries", made.libraries}, {"simd", made.simd}, {"command", made.command}, {"threads", o.threads}};
  const auto resolution = [](const BenchmarkOptions::Resolution& r) {
    return json{{"known_points", r.known_points}, {"seen_points", r.seen_points}, {"more_than_pixels", r.more_than_pixels}};
  };
  j["parameters"] = {{"views", o.views}, {"candidates", o.candidates}, {"seed", o.seed}, {"distance_m", o.distance}, {"gain_pixel_step", o.gain.pixel_step},
                     {"longest_side_m", o.subject.longest_side}, {"box_margin", o.subject.margin}, {"voxels", o.subject.voxels},
                     {"samples", o.subject.samples}, {"single", resolution(o.single)}, {"pair", resolution(o.pair)}};
  for (const SettingResult& s : result.settings) {
    json setting = {{"name", s.setting.name()}, {"poses", to_string(s.setting.set)}, {"sensor", to_string(s.setting.sensor)},
                    {"camera", to_string(s.setting.camera)}};
    for (std::size_t p = 0; p < s.setting.planners.size(); ++p) setting["summary"].push_back(summary_json(s, p));
    for (const ObjectResult& object : s.objects) {
      json item = {{"name", object.object}, {"sha256", object.sha256}, {"triangles", object.triangles}, {"samples", object.samples},
                   {"surface_voxels", object.voxels}, {"candidates", object.candidates}, {"visible_share", object.visible_share},
                   {"reachable_share", object.reachable_share}};
      for (const Run& run : object.runs) item["runs"].push_back(run_json(run, object));
      setting["objects"].push_back(std::move(item));
    }
    j["settings"].push_back(std::move(setting));
  }
  j["seconds"] = result.seconds;
  return j;
}

void without_times(json& j) {
  if (j.is_object()) {
    j.erase("seconds");
    j.erase("made");
  }
  if (j.is_structured())
    for (json& child : j) without_times(child);
}

std::string to_csv(const BenchmarkResult& result) {
  std::string out =
      "poses,sensor,camera,object,planner,view,candidate,coverage_all,coverage_visible,coverage_reachable,voxel_coverage_all,"
      "voxel_coverage_visible,unknown_voxels,predicted,travel_m,x_m,y_m,z_m,plan_s,look_s,model_s\n";
  char line[512];
  for (const SettingResult& s : result.settings)
    for (const ObjectResult& object : s.objects)
      for (const Run& run : object.runs)
        for (std::size_t n = 0; n < run.views.size(); ++n) {
          const ViewRecord& v = run.views[n];
          const Eigen::Vector3d p = v.X_OC.translation();
          std::snprintf(line, sizeof line, "%s,%s,%s,%s,%s,%zu,%d,%.6f,%.6f,%.6f,%.6f,%.6f,%.0f,%.4g,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n",
                        to_string(s.setting.set), to_string(s.setting.sensor), to_string(s.setting.camera), run.object.c_str(), run.planner.c_str(),
                        n + 1, v.candidate, v.all, v.visible, v.reachable, v.voxels_all, v.voxels_visible, v.unknown, v.predicted, v.travel, p.x(),
                        p.y(), p.z(), v.plan_seconds, v.look_seconds, v.model_seconds);
          out += line;
        }
  return out;
}

}  // namespace periplus::nbv_benchmark
