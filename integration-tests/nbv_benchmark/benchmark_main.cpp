// periplus-nbv-benchmark: viewpoint planners on the same objects, poses and sensors. README.md says what is measured and how.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/locate.h"
#include "integration-tests/nbv_benchmark/checks.h"
#include "integration-tests/nbv_benchmark/compare.h"
#include "integration-tests/nbv_benchmark/html_page.h"
#include "integration-tests/nbv_benchmark/kept.h"
#include "integration-tests/nbv_benchmark/measures.h"
#include "integration-tests/nbv_benchmark/report.h"
#include "integration-tests/nbv_benchmark/settings.h"
#include "services/nbv_planner/settings.h"

namespace {

namespace fs = std::filesystem;
using namespace periplus;
using namespace periplus::nbv_benchmark;

const std::string kHere = PERIPLUS_SOURCE_DIR "/integration-tests/nbv_benchmark/";

struct Arguments {
  std::string config = kHere + "config/default.yaml", catalogue = kHere + "config/objects.yaml";
  std::string planner_config, robot = PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like.yaml";
  std::string with, meshes, up_axis = "y", output = "runs/nbv-benchmark", keep, record;
  std::vector<std::string> objects, settings, planners, planner_set;
  int views = 0, candidates = 0, threads = 2;
  std::int64_t seed = -1;
  bool quick = false, check = false;
};

// The elements of `wanted`, all of which must be in `known`.
void must_be_known(const std::vector<std::string>& wanted, const std::vector<std::string>& known, const std::string& what) {
  for (const std::string& w : wanted) {
    std::string all;
    for (const std::string& k : known) all += " " + k;
    require(std::find(known.begin(), known.end(), w) != known.end(), ErrorCode::bad_input, "there is no " + what + " '" + w + "'; there are:" + all);
  }
}

BenchmarkOptions options_of(const Arguments& a) {
  config::Node root = config::load_file(a.config);
  if (!a.with.empty()) config::overlay(root, config::load_file(a.with));
  if (a.quick) config::overlay(root, config::load_file(kHere + "config/quick.yaml"));
  BenchmarkOptions o = read_options(root);
  const std::string planner_config = a.planner_config.empty() ? default_configuration("nbv_planner").string() : a.planner_config;
  const auto planner_with = [&](const config::Node& variant) {
    config::Node planner_root = config::load_file(planner_config);
    config::overlay(planner_root, root.child("planner"));
    for (const std::string& change : a.planner_set) {
      const std::size_t equal = change.find('=');
      require(equal != std::string::npos && equal > 0, ErrorCode::bad_input, "--planner-set wants dotted.key=value, not " + change);
      config::set(planner_root, change.substr(0, equal), change.substr(equal + 1));
    }
    config::overlay(planner_root, variant);
    return nbv::read_settings(planner_root);
  };
  const nbv::Settings planner = planner_with({});
  o.evaluation = planner.evaluation;
  o.search = planner.search;
  for (const std::string& name : root.child("variants").keys()) {
    const nbv::Settings variant = planner_with(root.child("variants").child(name));
    o.variants[name] = {variant.evaluation, variant.search};
  }
  o.objects = a.meshes.empty() ? read_catalogue(a.catalogue) : mesh_folder(a.meshes, a.up_axis);
  std::vector<std::string> names;
  for (const SubjectFile& f : o.objects) names.push_back(f.name);
  must_be_known(a.objects, names, "object");
  const auto in = [](const std::vector<std::string>& list, const std::string& word) { return std::find(list.begin(), list.end(), word) != list.end(); };
  if (!a.objects.empty()) std::erase_if(o.objects, [&](const SubjectFile& f) { return !in(a.objects, f.name); });
  if (a.quick && a.objects.empty() && a.meshes.empty() && o.objects.size() > 3) o.objects.resize(3);
  names.clear();
  for (const Setting& s : o.settings) names.push_back(s.name());
  must_be_known(a.settings, names, "setting");
  if (!a.settings.empty()) std::erase_if(o.settings, [&](const Setting& s) { return !in(a.settings, s.name()); });
  if (!a.planners.empty())
    for (Setting& s : o.settings) {
      s.planners = a.planners;
      if (s.set == PoseSet::dome) std::erase_if(s.planners, [](const std::string& p) { return !takes_lists(p); });
    }
  if (a.views > 0) o.views = a.views;
  if (a.candidates > 0) o.candidates = a.candidates;
  if (a.seed >= 0) o.seed = static_cast<std::uint64_t>(a.seed);
  o.subject.seed = o.seed;
  o.threads = a.threads;
  o.keep_folder = a.keep;
  o.record_folder = a.record;
  o.robot = robot::RobotModel::load_files(fs::path(a.robot).replace_extension(".urdf"), a.robot);
  return o;
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  require(file.good(), ErrorCode::io, "cannot write " + path.string());
}

void print(const BenchmarkResult& r) {
  for (const SettingResult& s : r.settings) {
    std::printf("\n%s\n", s.setting.name().c_str());
    for (std::size_t p = 0; p < s.setting.planners.size(); ++p) {
      std::vector<double> auc, plan;
      std::string line;
      for (const ObjectResult& o : s.objects) {
        std::vector<double> c;
        for (const ViewRecord& v : o.runs[p].views) {
          c.push_back(v.visible);
          if (c.size() > 1) plan.push_back(v.plan_seconds);
        }
        auc.push_back(area_under(c));
        char text[64];
        std::snprintf(text, sizeof text, "  %s %.1f", o.object.c_str(), 100 * c.back());
        line += text;
      }
      std::printf("  %-16s AUC %.4f  %6.0f ms a plan  coverage of the visible %%:%s\n", s.setting.planners[p].c_str(), mean(auc), 1000 * mean(plan), line.c_str());
    }
  }
  std::printf("\n%.0f s\n", r.seconds);
}

int run(const Arguments& a, const std::string& command) {
  const BenchmarkOptions o = options_of(a);
  fs::create_directories(a.output);
  const BenchmarkResult r = run_benchmark(o, [](const std::string& s) { std::fprintf(stderr, "%s\n", s.c_str()); });
  nlohmann::json report = to_json(r, o, provenance(command));
  const std::vector<Check> checks = check_criteria(report);
  if (a.check) report["checks"] = to_json(checks);
  write(fs::path(a.output) / "benchmark.json", report.dump() + "\n");
  write(fs::path(a.output) / "benchmark.csv", to_csv(r));
  write(fs::path(a.output) / "index.html", html_page(report));
  print(r);
  std::printf("%s/index.html, benchmark.json, benchmark.csv\n", a.output.c_str());
  if (!a.check) return 0;
  bool all = true;
  for (const Check& c : checks) {
    std::printf("%-5s %-32s %s %s %g %s\n", c.ok ? "ok" : "FAILS", c.name.c_str(), c.known ? nlohmann::json(c.value).dump().c_str() : "missing", c.comparison.c_str(), c.limit,
                c.detail.c_str());
    all = all && c.ok;
  }
  return all ? 0 : 1;
}

int recompute_all(const std::string& folder) {
  const Recomputed r = recompute(folder);
  for (const std::string& d : r.differences) std::printf("%s\n", d.c_str());
  std::printf("%d runs, %d views recomputed; largest difference of a coverage %.2g; %s\n", r.runs, r.views, r.largest,
              r.differences.empty() ? "all agree" : "NOT all agree");
  return r.differences.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Viewpoint planners on the same objects, poses and sensors; integration-tests/nbv_benchmark/README.md"};
  Arguments a;
  app.add_option("--config", a.config, "parameters and settings (YAML)");
  app.add_option("--with", a.with, "laid over the parameters (YAML), as config/variants.yaml");
  app.add_option("--catalogue", a.catalogue, "the objects (YAML)");
  app.add_option("--meshes", a.meshes, "a folder of meshes instead of the catalogue");
  app.add_option("--up", a.up_axis, "which axis of the folder's meshes points up")->check(CLI::IsMember({"x", "y", "z", "-x", "-y", "-z"}));
  app.add_option("--planner-config", a.planner_config, "parameters of our planner (YAML of nbv_planner)");
  app.add_option("--planner-set", a.planner_set, "one of them: dotted.key=value");
  app.add_option("--robot", a.robot, "robot YAML, its URDF beside it");
  app.add_option("--objects", a.objects, "only these")->delimiter(',');
  app.add_option("--settings", a.settings, "only these, as free/ideal/single")->delimiter(',');
  app.add_option("--planners", a.planners, "these in all settings")->delimiter(',');
  app.add_option("--views", a.views, "of each run");
  app.add_option("--candidates", a.candidates, "of the sets free and reachable");
  app.add_option("--seed", a.seed);
  app.add_option("--threads", a.threads, "results do not depend on it");
  app.add_option("--output", a.output, "folder of the results");
  app.add_option("--keep", a.keep, "keep poses and depth maps of each run in this folder");
  app.add_option("--record", a.record, "write a model file before each plan into this folder");
  app.add_flag("--check", a.check, "hold the result against the criteria; exit status 1 if one fails");
  app.add_flag("--quick", a.quick, "three objects, fewer views and poses: about a minute");
  std::string kept;
  std::string json_file;
  CLI::App* page = app.add_subcommand("page", "write index.html anew beside a benchmark.json");
  page->add_option("file", json_file, "benchmark.json")->required();
  CLI::App* again = app.add_subcommand("recompute", "recompute the coverages of the runs kept in a folder and hold them against what was reported");
  again->add_option("folder", kept, "as given to --keep")->required();
  std::vector<std::string> reports;
  CLI::App* beside = app.add_subcommand("compare", "planners beside each other over several benchmark.json, as of several seeds: a table in Markdown");
  beside->add_option("files", reports, "benchmark.json")->required();
  CLI11_PARSE(app, argc, argv);
  std::string command;
  for (int i = 1; i < argc; ++i) command += std::string(i > 1 ? " " : "") + argv[i];
  try {
    if (page->parsed()) {
      const fs::path html = fs::path(json_file).replace_filename("index.html");
      write(html, html_page(nlohmann::json::parse(read_file(json_file))));
      std::printf("%s\n", html.c_str());
      return 0;
    }
    if (beside->parsed()) {
      std::vector<nlohmann::json> parsed;
      for (const std::string& file : reports) parsed.push_back(nlohmann::json::parse(read_file(file)));
      std::printf("%s", to_markdown(compare(parsed), parsed).c_str());
      return 0;
    }
    return again->parsed() ? recompute_all(kept) : run(a, command);
  } catch (const Error& e) {
    std::fprintf(stderr, "periplus-nbv-benchmark: %s\n", e.what());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "periplus-nbv-benchmark: %s\n", e.what());
  }
  return 2;
}
