#include "integration-tests/nbv_benchmark/html_page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "integration-tests/nbv_benchmark/measures.h"
#include "integration-tests/nbv_benchmark/planners.h"

namespace periplus::nbv_benchmark {
namespace {

using nlohmann::json;

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  return out;
}

// The same colour for a planner everywhere; ours and the oracle stand out.
struct Style {
  std::string colour, dash;
  double width = 1.4;
};
Style style_of(const std::string& planner) {
  if (planner == "ours") return {"#0b5fa5", "", 3};
  if (planner == "search") return {"#19a0b8", "", 3};
  if (planner == "oracle") return {"#111", "5 4", 2};
  if (planner == "random") return {"#999", "2 3", 2};
  static const std::vector<std::string> colours = {"#d1495b", "#e58f2a", "#6a994e", "#8e5bb5", "#b5838d", "#7a6a53", "#c2b23a"};
  const auto names = nbv::information_gain_names();
  const auto at = std::find(names.begin(), names.end(), planner);
  if (at != names.end()) return {colours[static_cast<std::size_t>(at - names.begin()) % colours.size()], "", 1.4};
  // A variant: by its name, broken, so that it is not taken for a gain of the literature.
  std::size_t sum = 0;
  for (const char c : planner) sum = 31 * sum + static_cast<unsigned char>(c);
  return {colours[sum % colours.size()], "6 2", 1.8};
}

struct Series {
  std::string name;
  std::vector<double> values;   // 0..1
};

struct Frame {
  double width = 640, height = 380, left = 46, right = 12, top = 12, bottom = 36;
  bool legend = true;
};

// Coverage [%] over views; the vertical axis begins where the curves do.
std::string plot(const std::vector<Series>& series, const Frame& f, const std::string& title) {
  double low = 1;
  std::size_t views = 2;
  for (const Series& s : series)
    for (const double v : s.values) low = std::min(low, v), views = std::max(views, s.values.size());
  low = std::max(0.0, std::floor(low * 10) / 10);
  if (low > 0.9) low = 0.9;
  const double w = f.width - f.left - f.right, h = f.height - f.top - f.bottom;
  const auto x = [&](double view) { return f.left + w * (view - 1) / static_cast<double>(views - 1); };
  const auto y = [&](double share) { return f.top + h * (1 - (share - low) / (1 - low)); };
  std::string svg = "<svg viewBox='0 0 " + format("%.0f", f.width) + " " + format("%.0f", f.height) + "' role='img' aria-label='" + escape(title) + "'>";
  const double step = 1 - low > 0.45 ? 0.1 : 0.05;
  for (double g = low; g <= 1 + 1e-9; g += step) {
    svg += "<line class='g' x1='" + format("%.1f", f.left) + "' x2='" + format("%.1f", f.left + w) + "' y1='" + format("%.1f", y(g)) + "' y2='" + format("%.1f", y(g)) + "'/>";
    svg += "<text x='" + format("%.1f", f.left - 6) + "' y='" + format("%.1f", y(g) + 4) + "' text-anchor='end'>" + format("%.0f", 100 * g) + "</text>";
  }
  const std::size_t every = views > 12 ? 2 : 1;
  for (std::size_t v = 1; v <= views; v += every)
    svg += "<text x='" + format("%.1f", x(double(v))) + "' y='" + format("%.1f", f.top + h + 16) + "' text-anchor='middle'>" + std::to_string(v) + "</text>";
  svg += "<text x='" + format("%.1f", f.left + w / 2) + "' y='" + format("%.1f", f.height - 4) + "' text-anchor='middle'>" + escape(title) + "</text>";
  // Ours last, on top.
  std::vector<Series> order = series;
  std::stable_sort(order.begin(), order.end(), [](const Series& a, const Series& b) { return style_of(a.name).width < style_of(b.name).width; });
  for (const Series& s : order) {
    const Style style = style_of(s.name);
    std::string points;
    for (std::size_t i = 0; i < s.values.size(); ++i) points += format("%.1f", x(double(i + 1))) + "," + format("%.1f", y(s.values[i])) + " ";
    svg += "<polyline fill='none' stroke='" + style.colour + "' stroke-width='" + format("%.1f", style.width) + "'" +
           (style.dash.empty() ? "" : " stroke-dasharray='" + style.dash + "'") + " points='" + points + "'><title>" + escape(s.name) + "</title></polyline>";
  }
  if (f.legend) {
    double at = f.top + h - 10 - 15 * double(series.size() - 1);
    for (const Series& s : series) {
      const Style style = style_of(s.name);
      const double lx = f.left + w - 150;
      svg += "<line x1='" + format("%.1f", lx) + "' x2='" + format("%.1f", lx + 22) + "' y1='" + format("%.1f", at - 4) + "' y2='" + format("%.1f", at - 4) + "' stroke='" + style.colour +
             "' stroke-width='" + format("%.1f", style.width) + "'" + (style.dash.empty() ? "" : " stroke-dasharray='" + style.dash + "'") + "/>";
      svg += "<text class='l' x='" + format("%.1f", lx + 28) + "' y='" + format("%.1f", at) + "'>" + escape(s.name) + "</text>";
      at += 15;
    }
  }
  return svg + "</svg>";
}

std::string views_cell(const json& run, const char* level) {
  const json& v = run.at("views_to").at("visible").at(level);
  return v.is_number() ? std::to_string(v.get<int>()) : escape(v.get<std::string>());
}

std::string summary_table(const json& setting) {
  std::vector<json> rows(setting.at("summary").begin(), setting.at("summary").end());
  std::stable_sort(rows.begin(), rows.end(), [](const json& a, const json& b) { return a.at("auc_visible_mean") > b.at("auc_visible_mean"); });
  const std::size_t objects = setting.at("objects").size();
  std::string out =
      "<table><tr><th>planner</th><th>AUC</th><th>visible, %</th><th>worst object, %</th><th>all, %</th><th>views to 90 %</th><th>95 %</th><th>99 %</th>"
      "<th>travel, m</th><th>error, mm</th><th>a plan, ms</th></tr>";
  for (const json& r : rows) {
    const std::string name = r.at("planner");
    out += name == "ours" || name == "search" ? "<tr class='ours'>" : name == "oracle" ? "<tr class='oracle'>" : "<tr>";
    out += "<td>" + escape(name) + "</td><td>" + format("%.4f", r.at("auc_visible_mean")) + "</td><td>" + format("%.1f", 100 * r.at("coverage_visible_mean").get<double>()) + "</td><td>" +
           format("%.1f", 100 * r.at("coverage_visible_worst").get<double>()) + "</td><td>" + format("%.1f", 100 * r.at("coverage_all_mean").get<double>()) + "</td>";
    for (const char* level : {"90", "95", "99"}) {
      const json& v = r.at("views_to_visible").at(level);
      const auto reached = v.at("objects").get<std::size_t>();
      out += "<td>" + (reached == 0 ? std::string("&ndash;") : format("%.1f", v.at("mean"))) +
             (reached < objects ? " <small>(" + std::to_string(reached) + " of " + std::to_string(objects) + ")</small>" : "") + "</td>";
    }
    out += "<td>" + format("%.1f", r.at("travel_m_mean")) + "</td><td>" + format("%.2f", 1000 * r.at("surface_error_m_mean").get<double>()) + "</td><td>" +
           format("%.0f", 1000 * r.at("seconds").at("plan_mean").get<double>()) + "</td></tr>";
  }
  return out + "</table><p class='note'>Means over the objects, after the last view; AUC and views of the surface visible from the pose set. An object on which a level "
               "was not reached counts as one view more than were made; how many did reach it stands beside.</p>";
}

std::string object_table(const json& setting) {
  std::string out = "<table><tr><th>object</th><th>visible of all, %</th>";
  for (const json& s : setting.at("summary")) out += "<th>" + escape(s.at("planner")) + "</th>";
  out += "</tr>";
  for (const json& object : setting.at("objects")) {
    out += "<tr><td>" + escape(object.at("name")) + "</td><td>" + format("%.1f", 100 * object.at("visible_share").get<double>()) + "</td>";
    for (const json& run : object.at("runs"))
      out += "<td>" + views_cell(run, "90") + " / " + views_cell(run, "95") + " / " + views_cell(run, "99") + "<br><small>" +
             format("%.1f %%", 100 * run.at("coverage").at("visible").back().get<double>()) + "</small></td>";
    out += "</tr>";
  }
  return out + "</table><p class='note'>Views to 90 / 95 / 99 % of the visible surface, and the share after the last view. '&gt; N': another planner got there, this one did not "
               "within N views; 'not reachable': none did.</p>";
}

std::string checks_table(const json& checks) {
  std::string out = "<h2>What is asked for</h2><table><tr><th>criterion</th><th>value</th><th>limit</th><th></th><th></th></tr>";
  for (const json& c : checks)
    out += std::string(c.at("ok").get<bool>() ? "<tr>" : "<tr class='bad'>") + "<td>" + escape(c.at("name")) + "<br><small>" + escape(c.at("what")) + "</small></td><td>" +
           (c.at("value").is_null() ? "&ndash;" : format("%.4g", c.at("value"))) + "</td><td>" + escape(c.at("limit")) + "</td><td>" +
           (c.at("ok").get<bool>() ? "holds" : "fails") + "</td><td>" + escape(c.at("detail")) + "</td></tr>";
  return out + "</table>";
}

std::string setting_section(const json& setting) {
  static const std::map<std::string, std::string> poses = {{"dome", "48 views of a dome about a floating object"},
                                                           {"free", "free views from all sides, 0.6 to 2.5 m from a floating object"},
                                                           {"reachable", "views that the robot can take of an object on a table"}};
  const std::string name = setting.at("name");
  std::string out = "<h2>" + escape(poses.at(setting.at("poses"))) + "</h2><p>" +
                    (setting.at("sensor") == "ideal" ? "Ideal depth" : "Depth by stereo from rendered pictures") + ", " +
                    (setting.at("camera") == "single" ? "one camera of 640x480 and 60 degrees" : "the robot's pair of cameras") + " <small>(" + escape(name) + ")</small></p>";
  // Mean over the objects; a run that ended early keeps its last value.
  std::vector<Series> means;
  for (const json& s : setting.at("summary")) means.push_back({s.at("planner"), {}});
  std::size_t views = 0;
  for (const json& object : setting.at("objects"))
    for (const json& run : object.at("runs")) views = std::max(views, run.at("coverage").at("visible").size());
  for (std::size_t p = 0; p < means.size(); ++p)
    for (std::size_t v = 0; v < views; ++v) {
      std::vector<double> values;
      for (const json& object : setting.at("objects")) {
        const json& c = object.at("runs").at(p).at("coverage").at("visible");
        values.push_back(c.at(std::min(v, c.size() - 1)).get<double>());
      }
      means[p].values.push_back(mean(values));
    }
  out += "<div class='mean'>" + plot(means, {}, "views; mean coverage of the visible surface, %") + "</div>" + summary_table(setting);
  // One object each: ours, the bounds, and the best of the literature.
  std::string best;
  double auc = -1;
  for (const json& s : setting.at("summary"))
    if (literature(s.at("planner")) && s.at("auc_visible_mean").get<double>() > auc) auc = s.at("auc_visible_mean"), best = s.at("planner");
  out += "<div class='small'>";
  for (const json& object : setting.at("objects")) {
    std::vector<Series> few;
    for (const json& run : object.at("runs")) {
      const std::string planner = run.at("planner");
      if (!literature(planner) || planner == best) few.push_back({planner, run.at("coverage").at("visible").get<std::vector<double>>()});
    }
    out += plot(few, {250, 170, 30, 8, 8, 32, false}, object.at("name"));
  }
  out += "</div>" + (best.empty() ? std::string() : "<p class='note'>Of the literature only the best here, " + escape(best) + ", is drawn for each object.</p>") + object_table(setting);
  return out;
}

}  // namespace

std::string html_page(const json& r) {
  const json &made = r.at("made"), &p = r.at("parameters");
  std::string out = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Where to look next: viewpoint planners compared</title>
<style>
body { font: 15px/1.45 system-ui, "DejaVu Sans", sans-serif; color: #222; max-width: 1100px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.6em; margin-bottom: .2em; } h2 { font-size: 1.25em; margin-top: 2em; border-top: 1px solid #ddd; padding-top: .8em; }
table { border-collapse: collapse; margin: .8em 0; font-size: 13px; } th, td { padding: 3px 8px; text-align: right; border-bottom: 1px solid #e6e6e6; vertical-align: top; }
th { font-weight: 600; background: #f6f7f8; } td:first-child, th:first-child { text-align: left; }
tr.ours td { background: #eaf3fb; font-weight: 600; } tr.oracle td { color: #555; font-style: italic; } tr.bad td { background: #fdecea; }
small, .note { color: #666; font-weight: normal; } .note { font-size: 13px; margin-top: 0; }
.mean svg { width: 100%; max-width: 760px; } .small svg { width: 250px; margin: 4px; display: inline-block; }
svg text { font: 11px system-ui, "DejaVu Sans", sans-serif; fill: #444; } svg text.l { font-size: 12px; } svg .g { stroke: #e3e3e3; stroke-width: 1; }
code { background: #f3f4f5; padding: 0 3px; }
</style></head><body>
<h1>Where to look next: viewpoint planners compared</h1>
)";
  out += "<p>Every planner begins with the same first view of an object it knows nothing of, and names the next view until " + std::to_string(p.at("views").get<int>()) +
         " are made. A point of the true surface is covered once a depth point lies within " + format("%.0f", 1000 * p.at("distance_m").get<double>()) +
         " mm. <b>ours</b> is Periplus choosing among the same poses as its rivals, <b>search</b> Periplus choosing freely; <b>oracle</b> knows the object and always takes the pose "
         "that covers most; all others are gains of the literature.</p>";
  if (r.contains("checks")) out += checks_table(r.at("checks"));
  for (const json& setting : r.at("settings")) out += setting_section(setting);
  out += "<h2>How this was made</h2><table>";
  for (const auto& [key, value] : made.items()) out += "<tr><td>" + escape(key) + "</td><td style='text-align:left'>" + escape(value.is_string() ? value.get<std::string>() : value.dump()) + "</td></tr>";
  for (const auto& [key, value] : p.items()) out += "<tr><td>" + escape(key) + "</td><td style='text-align:left'>" + escape(value.dump()) + "</td></tr>";
  out += "<tr><td>seconds</td><td style='text-align:left'>" + format("%.0f", r.at("seconds")) + "</td></tr></table>";
  out += "<table><tr><th>object</th><th>triangles</th><th>SHA-256 of the file</th></tr>";
  if (!r.at("settings").empty())
    for (const json& object : r.at("settings").front().at("objects"))
      out += "<tr><td>" + escape(object.at("name")) + "</td><td>" + std::to_string(object.at("triangles").get<std::size_t>()) + "</td><td><code>" +
             escape(object.at("sha256").get<std::string>().substr(0, 16)) + "&hellip;</code></td></tr>";
  out += "</table><p class='note'>Definitions: integration-tests/nbv_benchmark/README.md. Everything shown here stands in benchmark.json and benchmark.csv beside this page.</p></body></html>\n";
  return out;
}

}  // namespace periplus::nbv_benchmark
