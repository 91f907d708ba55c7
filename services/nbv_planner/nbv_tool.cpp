// `periplus nbv`: the next best view of a model file, without a robot and without DDS. README.md, "On files".
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "common/core/config.h"
#include "common/core/error.h"
#include "common/core/version.h"
#include "common/core/locate.h"
#include "services/nbv_planner/tool/plan_input.h"
#include "services/nbv_planner/tool/plan_output.h"
#include "services/nbv_planner/tool/pose_text.h"
#include "services/nbv_planner/tool/term_map.h"
#include "services/nbv_planner/tool/view_picture.h"

namespace {

using namespace periplus;
using namespace periplus::nbv;

struct Options {
  std::string model, camera, scene, config, picture, from;
  std::vector<std::string> forbid, set, map;
  std::string method, max_evaluations, threads;
  double time_limit_s = 0;
  std::uint64_t seed = 1;
  bool json = false;
  MapSettings maps;
};

config::Node configuration(const Options& o) {
  const std::filesystem::path file = o.config.empty() ? default_configuration("nbv_planner") : std::filesystem::path(o.config);
  config::Node root = file.empty() ? config::Node() : config::load_file(file.string());
  for (const std::string& entry : o.set) {
    const std::size_t equal = entry.find('=');
    require(equal != std::string::npos && equal > 0, ErrorCode::bad_input, "--set " + entry + ": key=value is expected, for example search.starts=12");
    config::set(root, entry.substr(0, equal), entry.substr(equal + 1));
  }
  if (!o.method.empty()) config::set(root, "search.method", o.method);
  if (!o.max_evaluations.empty()) config::set(root, "search.max_evaluations", o.max_evaluations);
  if (!o.threads.empty()) config::set(root, "search.threads", o.threads);
  return root;
}

std::string percent(std::uint64_t part, std::uint64_t all) {
  char text[40];
  std::snprintf(text, sizeof text, "%.1f %%", all ? 100.0 * static_cast<double>(part) / static_cast<double>(all) : 0.0);
  return text;
}

void draw(const Options& o, const PlanInput& input, const Evaluator& evaluator, const Planned& planned) {
  const PlannedView& v = planned.view;
  ViewPicture picture;
  picture.title = "Next best view of " + input.object_id;
  char text[200];
  std::snprintf(text, sizeof text, "%s, %s; model of %zu views, voxels of %g m; scene %s", input.camera_name.c_str(),
                input.situation.rig.baseline > 0 ? "both eyes" : "one camera", input.situation.views.size(), input.situation.grid->geometry().voxel_size, input.scene_name.c_str());
  picture.subtitle = text;
  for (const ViewCandidate& c : v.candidates)
    picture.candidates.push_back({c.X_WC, c.f_e, evaluator.constraints().check(c.X_WC) == Violation::none});
  picture.X_WC = v.X_WC;
  picture.f_e = v.f_e;
  const Eigen::Vector3d p = v.X_WC.translation(), ypr = camera_yaw_pitch_roll(v.X_WC) * 57.29577951308232;
  const auto fact = [&](const char* name, const char* pattern, auto... values) {
    std::snprintf(text, sizeof text, pattern, values...);
    picture.facts.emplace_back(name, text);
  };
  fact("position", "%.3f, %.3f, %.3f m", p.x(), p.y(), p.z());
  fact("yaw, pitch, roll", "%.1f\u00b0, %.1f\u00b0, %.1f\u00b0", ypr.x(), ypr.y(), std::abs(ypr.z()) < 0.05 ? 0.0 : ypr.z());
  fact("N_u", "%d unknown voxels", v.evaluation.gain.voxels);
  fact("pixels", "%llu", static_cast<unsigned long long>(v.evaluation.gain.pixels));
  fact("f_e", "%.1f", v.f_e);
  fact("search", "%s, seed %llu", planned.method.c_str(), static_cast<unsigned long long>(planned.seed));
  fact("evaluations", "%d", v.evaluations);
  fact("unknown", "%s", percent(planned.counts.unknown, planned.counts.unknown + planned.counts.known + planned.counts.empty + planned.counts.environment).c_str());
  fact("forbidden", input.situation.forbidden.size() == 1 ? "%zu pose" : "%zu poses", input.situation.forbidden.size());
  draw_view(o.picture, evaluator, picture);
}

void make_map(const Options& o, const PlanInput& input, const Evaluator& evaluator) {
  std::vector<std::string> terms;
  if (o.map[0] == "all") {
    terms = {"f_e", "N_u", "K_forbidden", "sum_ls", "sum_ln", "K_distance", "K_far", "K_landmarks"};
  } else {
    for (std::size_t at = 0; at <= o.map[0].size();) {
      const std::size_t comma = std::min(o.map[0].find(',', at), o.map[0].size());
      terms.push_back(o.map[0].substr(at, comma - at));
      at = comma + 1;
    }
  }
  MapSettings settings = o.maps;
  settings.threads = input.settings.search.threads;
  char title[200];
  std::snprintf(title, sizeof title, "%s after %zu views: eyes at %g m, towards the object's centre", input.object_id.c_str(), input.situation.views.size(), settings.height);
  write_maps(o.map[1], evaluator, map_terms_around(evaluator, terms, settings), title, input.situation.views);
}

int plan(const Options& o) {
  const config::Node root = configuration(o);
  const Settings settings = read_settings(root);
  std::vector<Pose> forbidden;
  for (const std::string& text : o.forbid) forbidden.push_back(parse_pose(text, "--forbid"));
  const auto is_picture = [](const std::string& file) { return file.ends_with(".png") || file.ends_with(".svg"); };
  require(o.picture.empty() || is_picture(o.picture), ErrorCode::bad_input, "--picture " + o.picture + ": the name must end in .png or .svg");
  require(o.map.empty() || is_picture(o.map[1]) || o.map[1].ends_with(".csv"), ErrorCode::bad_input,
          "--map " + (o.map.empty() ? "" : o.map[0] + " " + o.map[1]) + ": the file's name must end in .png, .svg or .csv");
  if (!o.picture.empty()) require_writable(o.picture);
  if (!o.map.empty()) require_writable(o.map[1]);
  PlanInput input = read_input(o.model, o.camera, o.scene, forbidden, settings);
  if (!o.from.empty()) input.situation.X_WC_now = parse_pose(o.from, "--from");
  SearchSettings& search = input.settings.search;
  search.keep_candidates = !o.picture.empty();
  search.time_limit_s = o.time_limit_s;
  const Evaluator evaluator(input.situation, input.settings.evaluation, input.settings.constraints);
  if (!o.map.empty()) {
    make_map(o, input, evaluator);
    if (o.picture.empty() && !o.json) {
      std::cout << o.map[1] << "\n";
      return 0;
    }
  }

  Planned planned;
  planned.seed = o.seed;
  planned.method = search.method == SearchMethod::fast ? "fast" : search.method == SearchMethod::thorough ? "thorough" : "thesis";
  planned.counts = input.situation.grid->counts();
  const auto start = std::chrono::steady_clock::now();
  try {
    planned.view = plan_view(input.situation, o.seed, search, input.settings.evaluation, input.settings.constraints);
  } catch (const Error& e) {
    if (e.code() != ErrorCode::nbv_no_reachable_view) throw;
    planned.no_view = e.what();
  }
  planned.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (planned.no_view.empty()) {  // with the sums that a search leaves out
    Evaluator::Workspace workspace;
    const Evaluation e = evaluator.evaluate(planned.view.X_WC, workspace, Detail::every_term);
    for (auto& [name, value] : planned.view.terms) {
      if (name == "sum_ls") value = e.sum_ls;
      if (name == "sum_ln") value = e.sum_ln;
    }
  }
  std::cout << (o.json ? to_json(input, planned) : to_text(input, planned)) << std::flush;
  if (!planned.no_view.empty()) return 4;
  if (!o.picture.empty()) draw(o, input, evaluator, planned);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("The next best view of a model file, without a robot and without DDS.");
  app.name("periplus nbv");
  app.set_version_flag("--version", std::string("periplus ") + version());
  Options o;
  app.add_option("model", o.model, "model.periplus, of a run's folder or of `periplus model export --format periplus`")->required();
  app.add_option("camera", o.camera, "camera YAML: image, baseline, limits (deploy/cameras)")->required();
  app.add_option("--scene", o.scene, "scene YAML with the obstacles, instead of the camera's");
  app.add_option("--forbid", o.forbid, "left-eye pose that must not come back: x,y,z,yaw,pitch[,roll] [m, degrees] or x,y,z,qw,qx,qy,qz; may be repeated")
      ->take_all()->allow_extra_args(false);
  app.add_option("--from", o.from, "where the left eye is now, as for --forbid, instead of the model's last view: what K_motion counts from");
  app.add_option("--seed", o.seed, "of the search (1)");
  app.add_option("--method", o.method, "fast, thorough or thesis, instead of the configuration's");
  app.add_option("--max-evaluations", o.max_evaluations, "at most, instead of the configuration's");
  app.add_option("--time-limit", o.time_limit_s, "seconds; the best so far is printed then")->check(CLI::Range(0.0, 1e6));
  app.add_option("--threads", o.threads, "the result does not depend on it");
  app.add_option("--config", o.config, "the planner's configuration, instead of the installed one");
  app.add_option("--set", o.set, "key=value, into the configuration; may be repeated")->take_all()->allow_extra_args(false);
  app.add_flag("--json", o.json, "print JSON");
  app.add_option("--picture", o.picture, "FILE.png or FILE.svg: model, poses looked at, chosen view");
  app.add_option("--map", o.map, "TERM FILE: a term (or several, with commas; `all`) over the floor, as .png, .svg or .csv; without --picture or --json no view is searched")
      ->expected(2);
  app.add_option("--map-height", o.maps.height, "of the eyes on the map [m] (1.3)");
  app.add_option("--map-half-width", o.maps.half_width, "from the object's centre [m] (2.5)");
  app.add_option("--map-step", o.maps.step, "from place to place [m] (0.05)");
  app.footer("Exit status: 0 a view (its gain is 0 if nothing unknown is left), 2 what the caller can mend, 4 no reachable view, 1 otherwise.");
  try {
    app.parse(argc, argv);
    return plan(o);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const Error& e) {
    std::cerr << "periplus nbv: " << e.what() << std::endl;
    return e.code() == ErrorCode::internal ? 1 : 2;
  } catch (const std::exception& e) {
    std::cerr << "periplus nbv: " << e.what() << std::endl;
    return 1;
  }
}
