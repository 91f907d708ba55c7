#include "services/supervisor/run_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "common/core/error.h"
#include "common/scene/scene.h"
#include "services/supervisor/model_view.h"

namespace periplus::supervisor {

using nlohmann::json;

namespace {

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  require(file.good(), ErrorCode::io, "cannot read " + path + "; give the folder of a run, for example runs/20260101-120000-bunny");
  std::ostringstream s;
  s << file.rdbuf();
  return s.str();
}

std::string base64(const std::vector<unsigned char>& data) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < data.size(); i += 3) {
    const unsigned b = data[i] << 16 | (i + 1 < data.size() ? data[i + 1] << 8 : 0) | (i + 2 < data.size() ? data[i + 2] : 0);
    text += digits[b >> 18];
    text += digits[b >> 12 & 63];
    text += i + 1 < data.size() ? digits[b >> 6 & 63] : '=';
    text += i + 2 < data.size() ? digits[b & 63] : '=';
  }
  return text;
}

std::string jpeg(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, 82});
  return "data:image/jpeg;base64," + base64(bytes);
}

// A picture of the folder as data URI of the given width; empty if it is not there.
std::string picture(const std::string& path, int width) {
  const cv::Mat image = cv::imread(path);
  if (image.empty()) return "";
  cv::Mat small;
  cv::resize(image, small, {width, std::max(1, image.rows * width / image.cols)}, 0, 0, cv::INTER_AREA);
  return jpeg(small);
}

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') out += "&lt;";
    else if (c == '>') out += "&gt;";
    else if (c == '&') out += "&amp;";
    else if (c == '"') out += "&quot;";
    else out += c;
  }
  return out;
}

std::string number(double v, int decimals = 1) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, v);
  return text;
}

double value_or(const json& j, const char* key, double otherwise) {
  const auto it = j.find(key);
  return it != j.end() && it->is_number() ? it->get<double>() : otherwise;
}

const char* kind_colour(std::size_t i) {
  static const char* colours[] = {"#2a6f97", "#e76f51", "#2a9d8f", "#e9c46a", "#8d5a97", "#6c757d"};
  return colours[i % 6];
}

struct Series {
  std::string name;
  std::vector<double> values;   // by look; NaN where there is none
};

// A line chart over the looks with its axis from 0 to `top`.
std::string chart(const std::string& title, const std::vector<Series>& series, double top, const std::string& unit, int decimals) {
  constexpr double w = 460, h = 230, left = 52, right = 12, upper = 14, lower = 30;
  std::size_t looks = 1;
  for (const Series& s : series) looks = std::max(looks, s.values.size());
  const auto x = [&](std::size_t i) { return left + (w - left - right) * (looks > 1 ? static_cast<double>(i) / static_cast<double>(looks - 1) : 0.5); };
  const auto y = [&](double v) { return h - lower - (h - lower - upper) * v / top; };
  std::string svg = "<figure><figcaption>" + escape(title) + "</figcaption><svg viewBox=\"0 0 460 230\" role=\"img\" aria-label=\"" + escape(title) + "\">";
  for (int k = 0; k <= 4; ++k) {
    const double v = top * k / 4;
    svg += "<line class=grid x1=" + number(left) + " x2=" + number(w - right) + " y1=" + number(y(v)) + " y2=" + number(y(v)) + " /><text x=" + number(left - 6) +
           " y=" + number(y(v) + 4) + " text-anchor=end>" + number(v, decimals) + unit + "</text>";
  }
  for (std::size_t i = 0; i < looks; ++i)
    svg += "<text x=" + number(x(i)) + " y=" + number(h - 10) + " text-anchor=middle>" + std::to_string(i + 1) + "</text>";
  for (std::size_t s = 0; s < series.size(); ++s) {
    std::string points;
    for (std::size_t i = 0; i < series[s].values.size(); ++i) {
      const double v = series[s].values[i];
      if (!std::isfinite(v)) continue;
      points += number(x(i)) + "," + number(y(v)) + " ";
      svg += std::string("<circle r=3 cx=") + number(x(i)) + " cy=" + number(y(v)) + " fill=\"" + kind_colour(s) + "\"><title>" + escape(series[s].name) + ", look " +
             std::to_string(i + 1) + ": " + number(v, decimals) + unit + "</title></circle>";
    }
    svg += std::string("<polyline fill=none stroke-width=2 stroke=\"") + kind_colour(s) + "\" points=\"" + points + "\" />";
  }
  svg += "</svg><p class=legend>";
  for (std::size_t s = 0; s < series.size(); ++s) svg += std::string("<span><i style=\"background:") + kind_colour(s) + "\"></i>" + escape(series[s].name) + "</span>";
  return svg + "</p></figure>";
}

// The room from above: solids, the object's box, the walked path and the looks.
std::string room(const json& report, const std::string& scene_yaml) {
  const scene::Scene s = scene::parse_scene(scene_yaml, "scene.yaml");
  const double hx = s.room.size.x() / 2, hy = s.room.size.y() / 2;
  // World x to the right, y up.
  std::string svg = "<figure><figcaption>The room from above: path, looks and what each saw first</figcaption><svg class=room viewBox=\"" + number(-hx - 0.1, 2) + " " +
                    number(-hy - 0.1, 2) + " " + number(2 * hx + 0.2, 2) + " " + number(2 * hy + 0.2, 2) + "\"><g transform=\"scale(1,-1)\">";
  svg += "<rect class=wall x=" + number(-hx, 3) + " y=" + number(-hy, 3) + " width=" + number(2 * hx, 3) + " height=" + number(2 * hy, 3) + " />";
  for (const scene::Solid& solid : s.solids) {
    const Pose2 p = to_pose2(solid.X_WS);
    const std::string at = "transform=\"translate(" + number(p.x, 3) + "," + number(p.y, 3) + ") rotate(" + number(p.yaw * 180 / M_PI, 2) + ")\"";
    const std::string title = "<title>" + escape(solid.name) + "</title>";
    if (solid.shape == scene::Shape::box || solid.shape == scene::Shape::mesh)
      svg += "<rect class=" + std::string(solid.supports_object ? "table" : "solid") + " " + at + " x=" + number(-solid.size.x() / 2, 3) + " y=" + number(-solid.size.y() / 2, 3) +
             " width=" + number(solid.size.x(), 3) + " height=" + number(solid.size.y(), 3) + ">" + title + "</rect>";
    else
      svg += "<circle class=" + std::string(solid.supports_object ? "table" : "solid") + " " + at + " r=" + number(solid.size.x() / 2, 3) + ">" + title + "</circle>";
  }
  if (report.contains("object_box")) {
    const json& X = report.at("object_box").at("pose_world_box");
    const double yaw = std::atan2(X.at(1).at(0).get<double>(), X.at(0).at(0).get<double>());
    const json& size = report.at("object_box").at("size_m");
    const double sx = size.at(0).get<double>(), sy = size.at(1).get<double>();
    svg += "<rect class=box transform=\"translate(" + number(X.at(0).at(3).get<double>(), 3) + "," + number(X.at(1).at(3).get<double>(), 3) + ") rotate(" +
           number(yaw * 180 / M_PI, 2) + ")\" x=" + number(-sx / 2, 3) + " y=" + number(-sy / 2, 3) + " width=" + number(sx, 3) + " height=" + number(sy, 3) + " />";
  }
  for (const json& walk : report.value("walks", json::array())) {
    std::string points, feet;
    for (const json& p : walk.value("path", json::array())) points += number(p.at(0).get<double>(), 3) + "," + number(p.at(1).get<double>(), 3) + " ";
    svg += "<polyline class=path points=\"" + points + "\" />";
    for (const json& step : walk.value("steps", json::array()))
      svg += "<circle class=foot r=0.03 cx=" + number(step.at(1).get<double>(), 3) + " cy=" + number(step.at(2).get<double>(), 3) + " />";
  }
  const auto arrow = [&](const json& X, const char* kind, const std::string& label) {
    const double x = X.at(0).at(3).get<double>(), y = X.at(1).at(3).get<double>(), dx = X.at(0).at(2).get<double>(), dy = X.at(1).at(2).get<double>();
    const double n = std::max(1e-9, std::hypot(dx, dy));
    svg += std::string("<g class=") + kind + "><line x1=" + number(x, 3) + " y1=" + number(y, 3) + " x2=" + number(x + 0.3 * dx / n, 3) + " y2=" + number(y + 0.3 * dy / n, 3) +
           " /><circle r=0.06 cx=" + number(x, 3) + " cy=" + number(y, 3) + " /><text transform=\"translate(" + number(x - 0.12 * dx / n, 3) + "," + number(y - 0.12 * dy / n, 3) +
           ") scale(1,-1)\" text-anchor=middle dy=0.05>" + label + "</text></g>";
  };
  for (const json& X : report.value("forbidden_poses", json::array())) arrow(X, "forbidden", "x");
  for (const json& look : report.at("looks")) arrow(look.at("pose_world_camera"), "look", std::to_string(look.at("look").get<int>()));
  return svg + "</g></svg><p class=legend><span><i style=\"background:#b08968\"></i>table</span><span><i style=\"background:#8a8f98\"></i>obstacles</span>"
               "<span><i style=\"background:#2a6f97\"></i>looks</span><span><i style=\"background:#e9c46a\"></i>path and footsteps</span>"
               "<span><i style=\"background:#c1121f\"></i>forbidden poses</span></p></figure>";
}

std::string tile(const std::string& value, const std::string& name) {
  return "<div class=tile><b>" + escape(value) + "</b><span>" + escape(name) + "</span></div>";
}

const char* style =
    "body{font:15px/1.5 system-ui,sans-serif;color:#1d2733;background:#fbfaf7;max-width:1080px;margin:0 auto;padding:24px}"
    "h1{margin:0 0 4px}.room{max-height:640px}h2{margin:36px 0 10px;border-bottom:1px solid #d9d5cc;padding-bottom:4px}.sub{color:#5b6570;margin:0 0 18px}"
    ".tiles{display:flex;flex-wrap:wrap;gap:12px}.tile{background:#fff;border:1px solid #e4e0d7;border-radius:8px;padding:10px 16px;min-width:120px}"
    ".tile b{display:block;font-size:22px}.tile span{color:#5b6570;font-size:13px}.row{display:flex;flex-wrap:wrap;gap:20px}"
    "figure{margin:0;flex:1 1 300px;max-width:100%;box-sizing:border-box;background:#fff;border:1px solid #e4e0d7;border-radius:8px;padding:12px}figcaption{font-weight:600;margin-bottom:6px}"
    "svg{width:100%;height:auto}svg text{font-size:11px;fill:#5b6570}.grid{stroke:#e8e5de}.legend{margin:4px 0 0;font-size:13px;color:#5b6570}"
    ".legend span{margin-right:14px}.legend i{display:inline-block;width:10px;height:10px;border-radius:2px;margin-right:5px}"
    ".room text{font-size:.14px;font-weight:600}.room .wall{fill:#f4f1ea;stroke:#8a8f98;stroke-width:.05}.room .solid{fill:#8a8f98}.room .table{fill:#b08968}"
    ".room .box{fill:none;stroke:#e76f51;stroke-width:.02;stroke-dasharray:.06 .04}.room .path{fill:none;stroke:#e9c46a;stroke-width:.03}.room .foot{fill:#e9c46a}"
    ".room .look circle{fill:#2a6f97}.room .look line{stroke:#2a6f97;stroke-width:.03}.room .forbidden circle{fill:#c1121f}.room .forbidden line{stroke:#c1121f;stroke-width:.02}"
    "table{border-collapse:collapse;width:100%;background:#fff;font-size:13px}th,td{border:1px solid #e4e0d7;padding:4px 8px;text-align:right}th{background:#f4f1ea}"
    ".looks{display:grid;grid-template-columns:repeat(auto-fill,minmax(320px,1fr));gap:14px}.looks figure img{width:49%;border-radius:4px}"
    ".wide{overflow-x:auto}.views{display:grid;grid-template-columns:repeat(5,1fr);gap:10px}.views img{width:100%;border-radius:6px;border:1px solid #e4e0d7}"
    ".ok{color:#2a7d4f}.bad{color:#c1121f}";

}  // namespace

std::string html_report(const std::string& folder) {
  json report;
  try {
    report = json::parse(read_file(folder + "/report.json"));
    const json& looks = report.value("looks", json::array());
    const json exit = report.value("exit", json::object());
    const int status = exit.value("status", -1);
    std::string html = "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width,initial-scale=1\"><title>" +
                       escape(report.value("task", "run")) + "</title><style>" + style + "</style>";
    html += "<h1>" + escape(report.value("task", "run")) + "</h1><p class=sub>" + escape(report.value("run_id", "")) + " · " + escape(report.value("began", "")) +
            " · Periplus " + escape(report.value("version", "")) + " · seed " + std::to_string(report.value("seed", 0ull)) + " · <b class=" + (status == 0 ? "ok" : "bad") + ">" +
            escape(exit.value("state", "?")) + (exit.contains("status") ? " (exit " + std::to_string(status) + ")" : "") + "</b>: " + escape(exit.value("reason", "")) + "</p><div class=tiles>";
    if (report.contains("coverage_reachable")) html += tile(number(100 * report["coverage_reachable"].get<double>()) + " %", "of the reachable surface");
    if (report.contains("coverage_visible")) html += tile(number(100 * report["coverage_visible"].get<double>()) + " %", "of the visible surface");
    if (report.contains("surface_error"))
      html += tile(number(1000 * report["surface_error"]["model_to_truth"]["mean"].get<double>()) + " mm", "mean surface error");
    html += tile(std::to_string(looks.size()), "looks") + tile(number(report.value("wall_time_s", 0.0), 0) + " s", "wall time");
    if (!looks.empty()) html += tile(std::to_string(looks.back()["voxels"]["known"].get<long>()), "known voxels");
    html += "</div>";

    const std::string pictures = [&] {
      std::string s;
      for (const ModelView& view : model_views(folder + "/model.ply", 460)) {
        const cv::Mat rgb(view.image.height, view.image.width, CV_8UC3, const_cast<std::uint8_t*>(view.image.data.data()));
        cv::Mat bgr;
        cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
        s += "<figure><img alt=\"model from " + view.name + "\" src=\"" + jpeg(bgr) + "\"><p class=legend>from " + view.name + "</p></figure>";
      }
      return s;
    }();
    if (!pictures.empty()) html += "<h2>The model</h2><div class=views>" + pictures + "</div>";

    Series coverage{"reachable surface", {}}, visible{"visible surface", {}}, predicted{"predicted", {}}, found{"found", {}}, known{"known", {}}, unknown{"unknown", {}};
    double most_gain = 1, most_voxels = 1;
    for (const json& look : looks) {
      coverage.values.push_back(100 * value_or(look, "coverage", NAN));
      visible.values.push_back(100 * value_or(look, "coverage_visible", NAN));
      predicted.values.push_back(value_or(look, "predicted_gain_px", NAN));
      found.values.push_back(value_or(look, "found_gain_px", NAN));
      known.values.push_back(value_or(look["voxels"], "known", NAN));
      unknown.values.push_back(value_or(look["voxels"], "unknown", NAN));
      for (const double v : {predicted.values.back(), found.values.back()})
        if (std::isfinite(v)) most_gain = std::max(most_gain, v);
      for (const double v : {known.values.back(), unknown.values.back()})
        if (std::isfinite(v)) most_voxels = std::max(most_voxels, v);
    }
    html += "<h2>Look by look</h2><div class=row>";
    if (std::any_of(coverage.values.begin(), coverage.values.end(), [](double v) { return std::isfinite(v); }))
      html += chart("Coverage after each look", {coverage, visible}, 100, " %", 0);
    html += chart("Gain, predicted and found (pixels)", {predicted, found}, most_gain * 1.1, "", 0);
    html += chart("Voxels", {known, unknown}, most_voxels * 1.1, "", 0) + "</div>";
    if (std::filesystem::exists(folder + "/scene.yaml")) html += "<h2>The walk</h2>" + room(report, read_file(folder + "/scene.yaml"));

    std::vector<std::string> steps;   // columns: top-level states in the order of their first use
    for (const json& look : looks)
      for (const auto& [name, v] : look["seconds"].items())
        if (name.find('.') == std::string::npos && std::find(steps.begin(), steps.end(), name) == steps.end()) steps.push_back(name);
    html += "<h2>Times (s)</h2><div class=wide><table><tr><th>look</th>";
    for (const std::string& step : steps) html += "<th>" + escape(step) + "</th>";
    html += "<th>sum</th></tr>";
    for (const json& look : looks) {
      double sum = 0;
      html += "<tr><td>" + std::to_string(look["look"].get<int>()) + "</td>";
      for (const std::string& step : steps) {
        const double v = value_or(look["seconds"], step.c_str(), NAN);
        if (std::isfinite(v)) sum += v;
        html += "<td>" + (std::isfinite(v) ? number(v, 2) : std::string("")) + "</td>";
      }
      html += "<td>" + number(sum, 2) + "</td></tr>";
    }
    html += "</table></div><h2>What the robot saw</h2><div class=looks>";
    for (const json& look : looks) {
      char name[32];
      std::snprintf(name, sizeof name, "/looks/%02d/", look["look"].get<int>());
      html += "<figure><figcaption>look " + std::to_string(look["look"].get<int>()) + "</figcaption>";
      for (const char* kind : {"left", "right", "depth", "wide"})
        if (const std::string uri = picture(folder + name + kind + ".png", 320); !uri.empty())
          html += std::string("<img alt=\"") + kind + "\" title=\"" + kind + "\" src=\"" + uri + "\"> ";
      html += "</figure>";
    }
    html += "</div><h2>Services</h2><p>";
    const json vendors = report.value("vendors", json::object());
    for (const auto& [service, vendor] : vendors.items()) html += escape(service) + ": " + escape(vendor.get<std::string>()) + " &nbsp; ";
    return html + "</p><p class=sub>model digest " + escape(report.value("model_digest", "")) + "</p></html>\n";
  } catch (const json::exception& e) {
    throw_error(ErrorCode::bad_input, folder + "/report.json is damaged: " + e.what());
  }
}

void write_html_report(const std::string& folder) {
  const std::string html = html_report(folder);
  std::ofstream file(folder + "/report.html", std::ios::binary);
  file << html;
  file.close();
  require(file.good(), ErrorCode::io, "cannot write " + folder + "/report.html");
}

}  // namespace periplus::supervisor
