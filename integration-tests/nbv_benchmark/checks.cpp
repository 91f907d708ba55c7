#include "integration-tests/nbv_benchmark/checks.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "integration-tests/nbv_benchmark/measures.h"
#include "integration-tests/nbv_benchmark/planners.h"

namespace periplus::nbv_benchmark {
namespace {

using nlohmann::json;

const json* find(const json& list, const char* key, const std::string& value) {
  for (const json& item : list)
    if (item.at(key) == value) return &item;
  return nullptr;
}

std::vector<double> curve_of(const json& run, const char* which) { return run.at("coverage").at(which).get<std::vector<double>>(); }

// After view n (from 1), or the last one.
double after(const std::vector<double>& curve, std::size_t n) { return curve[std::min(n, curve.size()) - 1]; }

Check missing(const std::string& name, const std::string& what) { return {name, what, 0, ">=", 0, false, false, "not in this report"}; }

Check judged(const std::string& name, const std::string& what, double value, const std::string& comparison, double limit, const std::string& detail) {
  const bool ok = comparison == ">=" ? value >= limit : comparison == ">" ? value > limit : value <= limit;
  return {name, what, value, comparison, limit, ok, true, detail};
}

void coverage(const json& setting, const std::string& prefix, std::vector<Check>& checks) {
  std::vector<double> shares;
  std::string worst;
  for (const json& object : setting.at("objects"))
    if (const json* ours = find(object.at("runs"), "planner", "ours")) {
      shares.push_back(after(curve_of(*ours, "visible"), 10));
      if (shares.back() <= *std::min_element(shares.begin(), shares.end())) worst = object.at("name");
    }
  if (shares.empty()) {
    checks.push_back(missing(prefix + "mean_of_visible_10", "coverage after 10 views"));
    return;
  }
  checks.push_back(judged(prefix + "mean_of_visible_10", "share of the visible surface after 10 views, mean over the objects", mean(shares), ">=", 0.985, ""));
  checks.push_back(judged(prefix + "worst_of_visible_10", "the same, the worst object", *std::min_element(shares.begin(), shares.end()), ">=", 0.94, worst));
}

void behind_oracle(const json& setting, const std::string& prefix, std::vector<Check>& checks) {
  for (const double level : {0.90, 0.95}) {
    int worst = -1000;
    std::string detail;
    for (const json& object : setting.at("objects")) {
      const json *ours = find(object.at("runs"), "planner", "ours"), *oracle = find(object.at("runs"), "planner", "oracle");
      if (ours == nullptr || oracle == nullptr) continue;
      const std::vector<double> a = curve_of(*ours, "visible"), b = curve_of(*oracle, "visible");
      const auto at_ours = views_to(a, level), at_oracle = views_to(b, level);
      if (!at_ours && !at_oracle) continue;
      // Whoever did not get there needs at least one view more than were made.
      const int behind = at_ours.value_or(static_cast<int>(a.size()) + 1) - at_oracle.value_or(static_cast<int>(b.size()) + 1);
      if (behind < worst) continue;
      detail = behind == worst ? detail + ", " + object.at("name").get<std::string>() : object.at("name").get<std::string>();
      worst = behind;
    }
    const std::string percent = std::to_string(std::lround(100 * level)), name = prefix + "behind_oracle_" + percent;
    const std::string what = "views more than the oracle needs to " + percent + " % of the visible surface, at most";
    checks.push_back(worst == -1000 ? missing(name, what) : judged(name, what, worst, "<=", 1, detail));
  }
}

void literature_behind(const json& setting, const std::string& prefix, std::vector<Check>& checks) {
  const json* ours = find(setting.at("summary"), "planner", "ours");
  double best = -1;
  std::string rival;
  for (const json& s : setting.at("summary"))
    if (literature(s.at("planner")) && s.at("auc_visible_mean").get<double>() > best) {
      best = s.at("auc_visible_mean").get<double>();
      rival = s.at("planner");
    }
  const std::string what = "mean area under the coverage of the visible surface, less that of the best gain of the literature";
  checks.push_back(ours == nullptr || best < 0 ? missing(prefix + "ahead_of_literature", what)
                                               : judged(prefix + "ahead_of_literature", what, ours->at("auc_visible_mean").get<double>() - best, ">", 0, rival));
}

}  // namespace

std::vector<Check> check_criteria(const json& report) {
  std::vector<Check> checks;
  const json& settings = report.at("settings");
  const json* free_setting = find(settings, "name", "free/ideal/single");
  const json* bunny = free_setting == nullptr ? nullptr : find(free_setting->at("objects"), "name", "bunny");
  const json* ours = bunny == nullptr ? nullptr : find(bunny->at("runs"), "planner", "ours");
  const std::string what = "share of all of the bunny's surface after 6 views";
  checks.push_back(ours == nullptr ? missing("free.bunny_all_6", what) : judged("free.bunny_all_6", what, after(curve_of(*ours, "all"), 6), ">=", 0.99, ""));
  for (const json& setting : settings) {
    if (setting.at("sensor") != "ideal") continue;
    const std::string prefix = setting.at("poses").get<std::string>() + ".";
    coverage(setting, prefix, checks);
    behind_oracle(setting, prefix, checks);
    literature_behind(setting, prefix, checks);
  }
  // Stereo beside ideal depth with the same poses and cameras.
  bool compared = false;
  for (const json& stereo : settings) {
    if (stereo.at("sensor") != "stereo") continue;
    const std::string poses = stereo.at("poses"), camera = stereo.at("camera");
    const json* ideal = find(settings, "name", poses + "/ideal/" + camera);
    const json* a = find(stereo.at("summary"), "planner", "ours");
    const json* b = ideal == nullptr ? nullptr : find(ideal->at("summary"), "planner", "ours");
    if (a == nullptr || b == nullptr) continue;
    compared = true;
    checks.push_back(judged(poses + ".stereo_behind_ideal", "points of coverage of the visible surface that stereo is behind ideal depth, mean over the objects",
                            100 * (b->at("coverage_visible_mean").get<double>() - a->at("coverage_visible_mean").get<double>()), "<=", 3, ""));
  }
  if (!compared) checks.push_back(missing("stereo_behind_ideal", "stereo beside ideal depth"));
  return checks;
}

json to_json(const std::vector<Check>& checks) {
  json out = json::array();
  for (const Check& c : checks) {
    json j = {{"name", c.name}, {"what", c.what}, {"limit", c.comparison + " " + json(c.limit).dump()}, {"ok", c.ok}, {"detail", c.detail}};
    if (c.known)
      j["value"] = c.value;
    else
      j["value"] = nullptr;
    out.push_back(std::move(j));
  }
  return out;
}

}  // namespace periplus::nbv_benchmark
