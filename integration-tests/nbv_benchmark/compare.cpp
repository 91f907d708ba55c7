#include "integration-tests/nbv_benchmark/compare.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "common/core/error.h"
#include "integration-tests/nbv_benchmark/measures.h"

namespace periplus::nbv_benchmark {
namespace {

using nlohmann::json;

// What one planner did on one object.
struct Seen {
  std::vector<double> visible;
  double error = 0;
  std::vector<double> plan_seconds;
};
using Key = std::pair<std::uint64_t, std::string>;  // seed, object

int views_needed(const std::vector<double>& curve, double level) { return views_to(curve, level).value_or(static_cast<int>(curve.size()) + 1); }

Compared row_of(const std::string& setting, const std::string& planner, const std::map<Key, Seen>& mine, const std::map<Key, Seen>& first,
                const std::map<Key, Seen>* oracle) {
  Compared row{setting, planner, static_cast<int>(mine.size())};
  std::vector<double> auc, ahead, last, error, plan, views[3];
  if (oracle != nullptr) row.behind_oracle[0] = row.behind_oracle[1] = 0;
  for (const auto& [key, seen] : mine) {
    auc.push_back(area_under(seen.visible));
    ahead.push_back(auc.back() - area_under(first.at(key).visible));
    last.push_back(seen.visible.back());
    error.push_back(seen.error);
    for (std::size_t v = 1; v < seen.plan_seconds.size(); ++v) plan.push_back(seen.plan_seconds[v]);
    for (int l = 0; l < 3; ++l) views[l].push_back(views_needed(seen.visible, kLevels[l]));
    for (int l = 0; l < 2 && oracle != nullptr; ++l)
      if (views_needed(seen.visible, kLevels[l]) > views_needed(oracle->at(key).visible, kLevels[l]) + 1) ++row.behind_oracle[l];
  }
  row.auc = mean(auc);
  row.ahead = mean(ahead);
  double squares = 0;
  for (const double a : ahead) squares += (a - row.ahead) * (a - row.ahead);
  if (ahead.size() > 1) row.ahead_error = std::sqrt(squares / static_cast<double>(ahead.size() - 1) / static_cast<double>(ahead.size()));
  for (int l = 0; l < 3; ++l) row.views[l] = mean(views[l]);
  row.last = mean(last);
  row.error = mean(error);
  row.plan_seconds = mean(plan);
  return row;
}

}  // namespace

std::vector<Compared> compare(const std::vector<json>& reports) {
  require(!reports.empty(), ErrorCode::bad_input, "name at least one benchmark.json");
  std::vector<std::pair<std::string, std::vector<std::string>>> order;  // settings with their planners
  std::map<std::string, std::map<std::string, std::map<Key, Seen>>> all;
  for (const json& report : reports) {
    const auto seed = report.at("parameters").at("seed").get<std::uint64_t>();
    for (const json& setting : report.at("settings")) {
      const std::string name = setting.at("name");
      if (!all.contains(name)) {
        order.push_back({name, {}});
        for (const json& s : setting.at("summary")) order.back().second.push_back(s.at("planner"));
      }
      for (const json& object : setting.at("objects"))
        for (const json& run : object.at("runs")) {
          Seen seen{run.at("coverage").at("visible"), run.at("surface_error_m").at("mean"), run.at("seconds").at("plan")};
          require(!seen.visible.empty(), ErrorCode::bad_input, "a run of the setting " + name + " has no view");
          const std::string object_name = object.at("name");
          const bool is_new = all[name][run.at("planner")].emplace(Key{seed, object_name}, std::move(seen)).second;
          require(is_new, ErrorCode::bad_input, "seed " + std::to_string(seed) + " of the setting " + name + " is there twice with the object " + object_name);
        }
    }
  }
  std::vector<Compared> rows;
  for (const auto& [name, planners] : order) {
    const auto& by_planner = all.at(name);
    const auto& first = by_planner.at(planners.front());
    for (const auto& [planner, seen] : by_planner)
      require(seen.size() == first.size(), ErrorCode::bad_input, "the planner " + planner + " did not run on all objects and seeds of the setting " + name);
    const auto oracle = by_planner.find("oracle");
    for (const std::string& planner : planners)
      rows.push_back(row_of(name, planner, by_planner.at(planner), first, oracle == by_planner.end() ? nullptr : &oracle->second));
  }
  return rows;
}

std::string to_markdown(const std::vector<Compared>& rows, const std::vector<json>& reports) {
  std::string out, setting, seeds;
  std::set<std::string> made;
  for (const json& r : reports) {
    seeds += (seeds.empty() ? "" : ", ") + r.at("parameters").at("seed").dump();
    made.insert(r.at("made").at("commit").get<std::string>() + ", " + r.at("made").at("machine").get<std::string>());
  }
  for (const Compared& r : rows) {
    char line[512];
    if (r.setting != setting) {
      setting = r.setting;
      out += (out.empty() ? "" : "\n") + ("**" + setting + "**, " + std::to_string(r.runs) + " runs of each planner\n\n") +
             "| planner | AUC | beyond `" + r.planner + "`, x 10^-4 | views to 90 % | 95 % | 99 % | last, % | > 1 view behind the oracle at 90 % | 95 % | error, mm | plan, s |\n" +
             "|---|---|---|---|---|---|---|---|---|---|---|\n";
    }
    std::string behind[2];
    for (int l = 0; l < 2; ++l) behind[l] = r.behind_oracle[l] < 0 ? "" : std::to_string(r.behind_oracle[l]);
    std::snprintf(line, sizeof line, "| `%s` | %.4f | %+.0f ± %.0f | %.2f | %.2f | %.2f | %.2f | %s | %s | %.2f | %.2f |\n", r.planner.c_str(), r.auc, 1e4 * r.ahead,
                  1e4 * r.ahead_error, r.views[0], r.views[1], r.views[2], 100 * r.last, behind[0].c_str(), behind[1].c_str(), 1000 * r.error, r.plan_seconds);
    out += line;
  }
  out += "\nSeeds " + seeds + "; commit and machine:";
  for (const std::string& m : made) out += " " + m + ".";
  return out + "\n";
}

}  // namespace periplus::nbv_benchmark
