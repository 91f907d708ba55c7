#include "services/nbv_planner/tool/term_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <numbers>

#include "common/core/config.h"
#include "common/core/error.h"
#include "services/nbv_planner/task_runner.h"

namespace periplus::nbv {
namespace {

constexpr double kMostPlaces = 1e6;

struct Scale {
  double low = 0, high = 1;
  bool low_is_good = false, cut_high = false;
};

Scale scale_of(const TermMap& map, double greatest) {
  Scale s{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (double v : map.values) {
    if (!std::isfinite(v)) continue;
    s.low = std::min(s.low, v);
    s.high = std::max(s.high, v);
  }
  if (!(s.low <= s.high)) s = {0, 1};
  double most = std::numeric_limits<double>::infinity();
  // A penalty of 1 is where its bound is reached; f_e of `greatest` is what a violated constraint costs.
  if (map.term == "f_e") most = std::max(greatest, 1.0);
  if (map.term == "K_landmarks") most = s.high;
  else if (map.term.starts_with("K_") && map.term != "K_forbidden") most = 1;
  s.low_is_good = map.term == "f_e" || map.term.starts_with("K_");
  s.cut_high = s.high > most;
  s.high = std::min(s.high, most);
  if (s.high - s.low < 1e-12) s.high = s.low + 1;
  return s;
}

std::string number(double v) {
  char text[40];
  std::snprintf(text, sizeof text, std::abs(v) >= 1e5 ? "%.2g" : std::abs(v) >= 100 ? "%.0f" : "%.3g", v);
  return text;
}

const char* meaning(const std::string& term) {
  const std::pair<const char*, const char*> known[] = {
      {"f_e", "evaluation function (3.15)"}, {"value", "what the search maximises"}, {"N_u", "unknown voxels seen"},
      {"pixels", "unknown pixels seen"}, {"quality", "known surface seen better"}, {"K_height", "height (3.7)"}, {"K_roll", "roll (3.7)"}, {"K_pitch", "pitch (3.7)"},
      {"K_yaw", "yaw (3.7)"}, {"K_distance", "least distance (3.8)"}, {"K_far", "greatest distance"}, {"K_landmarks", "landmarks (3.11-3.13)"},
      {"K_forbidden", "forbidden poses (3.14)"}, {"K_motion", "motion"}, {"K_reach", "reachability"}, {"visible_landmarks", "landmarks: \u2211 ls\u00b7ln"},
      {"sum_ls", "landmarks: \u2211 ls (3.9)"}, {"sum_ln", "landmarks: \u2211 ln (3.10)"}};
  for (const auto& [name, text] : known)
    if (term == name) return text;
  return "";
}

ImageU8 picture_of(const TermMap& map, int count, const Scale& scale) {
  ImageU8 image(count, count, 3);
  for (int row = 0; row < count; ++row) {
    for (int column = 0; column < count; ++column) {
      const double v = map.values[static_cast<std::size_t>(row) * count + column];
      Colour c{0.80, 0.80, 0.80};
      if (std::isfinite(v)) {
        const double share = (std::clamp(v, scale.low, scale.high) - scale.low) / (scale.high - scale.low);
        c = viridis(scale.low_is_good ? 1 - share : share);
      }
      const double rgb[] = {c.r, c.g, c.b};
      for (int k = 0; k < 3; ++k) image.at(column, count - 1 - row, k) = static_cast<std::uint8_t>(std::lround(255 * rgb[k]));
    }
  }
  return image;
}

std::vector<std::vector<Eigen::Vector2d>> outlines(const Situation& s) {
  std::vector<std::vector<Eigen::Vector2d>> all;
  for (const scene::Solid& solid : s.scene.solids) {
    std::vector<Eigen::Vector2d> line;
    const int n = solid.shape == scene::Shape::box || solid.shape == scene::Shape::mesh ? 4 : 48;
    for (int i = 0; i <= n; ++i) {
      const double a = 2 * std::numbers::pi * (i + (n == 4 ? 0.5 : 0)) / n, r = n == 4 ? std::numbers::sqrt2 / 2 : 0.5;
      line.push_back((solid.X_WS * Eigen::Vector3d(r * solid.size.x() * std::cos(a), r * solid.size.y() * std::sin(a), 0)).head<2>());
    }
    all.push_back(line);
  }
  return all;
}

}  // namespace

std::vector<std::string> map_terms() {
  return {"f_e",        "value",   "N_u",         "pixels",      "quality",     "K_height", "K_roll",  "K_pitch",          "K_yaw",  "K_distance",
          "K_far", "K_landmarks", "K_forbidden", "K_motion", "K_reach", "visible_landmarks", "sum_ls", "sum_ln"};
}

TermMaps map_terms_around(const Evaluator& evaluator, const std::vector<std::string>& terms, const MapSettings& settings) {
  require(!terms.empty(), ErrorCode::bad_input, "a map needs the name of a term");
  for (const std::string& term : terms) {
    const std::vector<std::string> known = map_terms();
    if (std::find(known.begin(), known.end(), term) != known.end()) continue;
    std::string all;
    for (const std::string& name : known) all += " " + name;
    throw_error(ErrorCode::bad_input, "there is no term '" + term + "'; did you mean '" + config::nearest(term, known) + "'? There are:" + all);
  }
  require(std::isfinite(settings.height) && settings.height >= 0 && settings.height <= 100, ErrorCode::bad_input, "a map's height must lie in 0..100 m");
  require(settings.step > 0 && settings.half_width > 0 && settings.half_width <= 100, ErrorCode::bad_input,
          "a map's step must be positive, and its half width lie in 0..100 m");
  const double along = 2 * std::floor(settings.half_width / settings.step + 1e-9) + 1;
  require(along * along <= kMostPlaces, ErrorCode::bad_input, "a map may have at most a million places: choose a larger --map-step or a smaller --map-half-width");

  const Situation& s = evaluator.situation();
  const voxel::GridGeometry& g = s.grid->geometry();
  const Eigen::Vector3d middle = g.X_WG * (g.size.cast<double>() * g.voxel_size / 2);
  TermMaps result;
  result.count = static_cast<int>(along);
  result.step = settings.step;
  result.height = settings.height;
  result.first = middle.head<2>().array() - (result.count - 1) / 2 * settings.step;
  std::vector<Evaluation> evaluations(static_cast<std::size_t>(result.count) * result.count);
  std::vector<char> outside(evaluations.size(), 0);
  const int workers = std::clamp(settings.threads, 1, 64);
  on_threads(workers, [&](int worker) {
    Evaluator::Workspace workspace;
    for (int row = worker; row < result.count; row += workers) {
      for (int column = 0; column < result.count; ++column) {
        const Eigen::Vector3d p(result.first.x() + column * settings.step, result.first.y() + row * settings.step, settings.height);
        if (s.collision->contains(p) || s.grid->state(g.voxel_of(p)) != voxel::VoxelState::empty) continue;
        const Eigen::Vector3d d = middle - p;
        const double yaw = std::atan2(d.y(), d.x()), pitch = std::atan2(-d.z(), d.head<2>().norm());
        const std::size_t at = static_cast<std::size_t>(row) * result.count + column;
        const Pose X_WC = look_along(p, yaw, pitch) * Pose(Eigen::Translation3d(-s.rig.baseline / 2, 0, 0));
        evaluations[at] = evaluator.evaluate(X_WC, workspace, Detail::every_term);
        outside[at] = 1;
      }
    }
  });
  result.greatest = 1;
  for (const Evaluation& e : evaluations) result.greatest = std::max(result.greatest, e.value);
  for (const std::string& term : terms) result.maps.push_back({term, {}});
  for (TermMap& map : result.maps) map.values.assign(evaluations.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < evaluations.size(); ++i) {
    if (!outside[i]) continue;
    for (const auto& [name, value] : evaluator.terms(evaluations[i], result.greatest))
      for (TermMap& map : result.maps)
        if (map.term == name) map.values[i] = value;
  }
  return result;
}

void write_maps(const std::string& file, const Evaluator& evaluator, const TermMaps& maps, const std::string& title,
                const std::vector<Pose>& seen_from) {
  if (file.ends_with(".csv")) {
    std::ofstream out(file);
    out << "x_m,y_m,z_m";
    for (const TermMap& map : maps.maps) out << "," << map.term;
    out << "\n";
    for (std::size_t i = 0; i < maps.maps.front().values.size(); ++i) {
      char text[64];
      std::snprintf(text, sizeof text, "%.6g,%.6g,%.6g", maps.first.x() + static_cast<double>(i % maps.count) * maps.step,
                    maps.first.y() + static_cast<double>(i / maps.count) * maps.step, maps.height);
      out << text;
      for (const TermMap& map : maps.maps) {
        out << ",";
        if (std::isfinite(map.values[i])) {
          std::snprintf(text, sizeof text, "%.9g", map.values[i]);
          out << text;
        }
      }
      out << "\n";
    }
    out.close();
    require(!out.fail(), ErrorCode::io, "cannot write " + file + "; choose a folder that exists and may be written");
    return;
  }

  const Situation& s = evaluator.situation();
  const Colour ink{0.13, 0.15, 0.18}, soft{0.45, 0.48, 0.52}, white{1, 1, 1};
  const bool object = maps.maps.size() > 1;
  const int panels = static_cast<int>(maps.maps.size()) + object, columns = std::min(panels, 3), rows = (panels + columns - 1) / columns;
  constexpr double kMap = 400, kCell = 510, kRow = 468, kTop = 62;
  Canvas canvas(file, 30 + columns * kCell, kTop + rows * kRow + 16);
  canvas.text(30, 34, title, 20, ink, Align::left, true);
  const auto outline = outlines(s);
  for (int i = 0; i < panels; ++i) {
    const double x = 30 + i % columns * kCell, y = kTop + static_cast<double>(i / columns) * kRow;
    if (object && i == 0) {
      canvas.text(x, y + 16, "the object and its surroundings", 15, ink, Align::left, true);
      std::vector<SideViewPose> poses;
      for (const Pose& X : seen_from) poses.push_back({X, {0.84, 0.10, 0.16}, 0.25, 0});
      // Seen from beside the views, so that what they showed is in sight.
      Eigen::Vector3d from(1, -0.7, 0);
      if (!seen_from.empty()) {
        from.setZero();
        for (const Pose& X : seen_from) from += X.translation() - s.grid->geometry().X_WG * (s.grid->geometry().size.cast<double>() * s.grid->geometry().voxel_size / 2);
      }
      draw_side_view(canvas, s, poses, std::atan2(from.y(), from.x()) - 0.9, x, y + 26, 470, 400);
      continue;
    }
    const TermMap& map = maps.maps[i - object];
    const Scale scale = scale_of(map, maps.greatest);
    canvas.text(x, y + 16, map.term, 15, ink, Align::left, true);
    canvas.text(x + canvas.text_width(map.term, 15, true) + 10, y + 16, meaning(map.term), 14, soft);
    const double px = kMap / maps.count;
    canvas.image(picture_of(map, maps.count, scale), x, y + 26, kMap, kMap, true);
    const auto at = [&](const Eigen::Vector2d& p) {
      const Eigen::Vector2d cell = (p - maps.first) / maps.step;
      return Eigen::Vector2d(x + (cell.x() + 0.5) * px, y + 26 + kMap - (cell.y() + 0.5) * px);
    };
    canvas.clip(x, y + 26, kMap, kMap);
    for (const auto& line : outline) {
      std::vector<Eigen::Vector2d> points;
      for (const auto& p : line) points.push_back(at(p));
      canvas.line(points, white.with_alpha(0.9), 2.6);
      canvas.line(points, ink, 1.1);
    }
    const voxel::GridGeometry& g = s.grid->geometry();
    std::vector<Eigen::Vector2d> box;
    for (int c : {0, 1, 3, 2, 0})
      box.push_back(at((g.X_WG * (Eigen::Vector3d(c & 1, c >> 1, 0).cwiseProduct(g.size.cast<double>()) * g.voxel_size)).head<2>()));
    canvas.line(box, white, 1.4, true);
    for (const Pose& X : seen_from) {  // where the object was perceived from
      const Eigen::Vector2d p = at(X.translation().head<2>()), q = at((X * Eigen::Vector3d(0, 0, 0.35)).head<2>());
      canvas.line({p, q}, white, 3.4);
      canvas.line({p, q}, {0.84, 0.10, 0.16}, 2);
      canvas.disc(p, 5, white);
      canvas.disc(p, 3.8, {0.84, 0.10, 0.16});
    }
    canvas.unclip();
    canvas.rectangle(x, y + 26, kMap, kMap, soft, 1);
    // Its scale.
    ImageU8 bar(1, 128, 3);
    for (int k = 0; k < 128; ++k) {
      const Colour c = viridis(scale.low_is_good ? k / 127.0 : 1 - k / 127.0);
      bar.at(0, k, 0) = static_cast<std::uint8_t>(255 * c.r);
      bar.at(0, k, 1) = static_cast<std::uint8_t>(255 * c.g);
      bar.at(0, k, 2) = static_cast<std::uint8_t>(255 * c.b);
    }
    canvas.image(bar, x + kMap + 12, y + 26, 14, kMap);
    canvas.text(x + kMap + 32, y + 38, (scale.cut_high ? "\u2265 " : "") + number(scale.high), 13, ink);
    canvas.text(x + kMap + 32, y + 30 + kMap / 2, number((scale.high + scale.low) / 2), 13, ink);
    canvas.text(x + kMap + 32, y + 26 + kMap, number(scale.low), 13, ink);
    // Metres, from the first place on.
    char text[60];
    std::snprintf(text, sizeof text, "x %.1f to %.1f m", maps.first.x(), maps.first.x() + (maps.count - 1) * maps.step);
    canvas.text(x, y + 26 + kMap + 17, text, 12, soft);
    std::snprintf(text, sizeof text, "y %.1f to %.1f m", maps.first.y(), maps.first.y() + (maps.count - 1) * maps.step);
    canvas.text(x + kMap, y + 26 + kMap + 17, text, 12, soft, Align::right);
  }
  canvas.save();
}

}  // namespace periplus::nbv
