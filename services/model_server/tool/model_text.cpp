#include "services/model_server/tool/model_text.h"

#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>

namespace periplus::model {

namespace {

using nlohmann::json;
using object_model::ObjectModel;
using object_model::ModelState;

template <class... Values>
std::string line(const char* pattern, Values... values) {
  char text[400];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

std::string time_text(std::int64_t stamp_ns) {
  const std::time_t seconds = stamp_ns / 1000000000;
  std::tm parts{};
  char text[40] = "?";
  if (::gmtime_r(&seconds, &parts)) std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

// What may come from a file, on one line.
std::string printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
  return text;
}

double share_known(const voxel::Counts& c) {
  const double learnt = static_cast<double>(c.known + c.empty), all = learnt + static_cast<double>(c.unknown);
  return all > 0 ? learnt / all : 0;
}

json rows(const Pose& X) {
  json out = json::array();
  for (int r = 0; r < 3; ++r) out.push_back({X.matrix()(r, 0), X.matrix()(r, 1), X.matrix()(r, 2), X.matrix()(r, 3)});
  return out;
}

json counts_json(const voxel::Counts& c) { return {{"unknown", c.unknown}, {"known", c.known}, {"empty", c.empty}, {"environment", c.environment}}; }

json summary(const ObjectModel& m) {
  const ModelState& s = m.state();
  return {{"object", s.object_id},
          {"revision", s.grid.revision},
          {"views", s.views.size()},
          {"voxel_m", s.grid.geometry().voxel_size},
          {"size", {s.grid.geometry().size.x(), s.grid.geometry().size.y(), s.grid.geometry().size.z()}},
          {"counts", counts_json(s.grid.counts())},
          {"imported", s.imported},
          {"digest", m.digest()}};
}

}  // namespace

std::string list_text(const std::vector<ObjectModel>& models) {
  if (models.empty()) return "no object is stored\n";
  std::size_t widest = 6;
  for (const ObjectModel& m : models) widest = std::max(widest, m.state().object_id.size());
  const int wide = static_cast<int>(widest);
  std::string out = line("%-*s  revision  views  voxel mm  seen %%     known   unknown\n", wide, "object");
  for (const ObjectModel& m : models) {
    const ModelState& s = m.state();
    const voxel::Counts c = s.grid.counts();
    out += line("%-*s  %8u  %5zu  %8.4g  %6.1f  %8llu  %8llu%s\n", wide, printable(s.object_id).c_str(), s.grid.revision, s.views.size(),
                1000 * s.grid.geometry().voxel_size, 100 * share_known(c), static_cast<unsigned long long>(c.known),
                static_cast<unsigned long long>(c.unknown), s.imported ? "  imported" : "");
  }
  return out;
}

std::string show_text(const ObjectModel& m) {
  const ModelState& s = m.state();
  const voxel::GridGeometry& g = s.grid.geometry();
  const voxel::Counts c = s.grid.counts();
  const Eigen::Vector3d p = s.box.X_WB.translation();
  std::string out = printable(s.object_id) + "\n";
  out += line("  revision     %u%s\n", s.grid.revision, s.imported ? ", imported" : "");
  out += line("  digest       %s\n", m.digest().c_str());
  out += line("  box          %.3f x %.3f x %.3f m about (%.3f, %.3f, %.3f)\n", s.box.size.x(), s.box.size.y(), s.box.size.z(), p.x(), p.y(), p.z());
  out += line("  grid         %d x %d x %d voxels of %.4g mm\n", g.size.x(), g.size.y(), g.size.z(), 1000 * g.voxel_size);
  out += line("  voxels       %llu known, %llu empty, %llu unknown, %llu environment\n", static_cast<unsigned long long>(c.known), static_cast<unsigned long long>(c.empty),
              static_cast<unsigned long long>(c.unknown), static_cast<unsigned long long>(c.environment));
  out += line("  environment  %s\n", printable(s.environment_revision).c_str());
  out += line("  carve again  %s\n", m.can_be_revised() ? "yes: all views keep their depth" : "no");
  out += line("  views        %zu\n", s.views.size());
  if (!s.views.empty()) out += "    view                 position [m]             features  revision    unknown less by\n";
  for (const auto& v : s.views) {
    const Eigen::Vector3d e = v->X_WC.translation();
    out += line("    %-20s (%7.3f, %7.3f, %7.3f)  %8zu  %8u  %17.0f\n", printable(v->view_id).c_str(), e.x(), e.y(), e.z(), v->features.size(), v->result.revision,
                v->result.found_gain_voxels);
  }
  out += line("  history      %zu\n", s.history.size());
  for (const object_model::ModelEvent& e : s.history)
    out += line("    %s  revision %-4u %s  %s  (periplus %s)\n", time_text(e.stamp_ns).c_str(), e.revision, printable(e.what).c_str(), printable(e.detail).c_str(),
                printable(e.program).c_str());
  return out;
}

json list_json(const std::vector<ObjectModel>& models) {
  json out = json::array();
  for (const ObjectModel& m : models) out.push_back(summary(m));
  return out;
}

json show_json(const ObjectModel& m) {
  const ModelState& s = m.state();
  json out = summary(m);
  out["environment_revision"] = s.environment_revision;
  out["can_be_revised"] = m.can_be_revised();
  out["box"] = {{"pose_world_box", rows(s.box.X_WB)}, {"size_m", {s.box.size.x(), s.box.size.y(), s.box.size.z()}}};
  out["pose_world_grid"] = rows(s.grid.geometry().X_WG);
  out["view"] = json::array();
  for (const auto& v : s.views)
    out["view"].push_back({{"view_id", v->view_id}, {"stamp_ns", v->stamp_ns}, {"pose_world_camera", rows(v->X_WC)}, {"features", v->features.size()}, {"depth_maps", v->depth.size()},
                           {"revision", v->result.revision}, {"counts", counts_json(v->result.counts)}, {"found_gain_px", v->result.found_gain_px},
                           {"found_gain_voxels", v->result.found_gain_voxels}, {"silhouette_valid_share", v->silhouette_valid_share}});
  out["history"] = json::array();
  for (const object_model::ModelEvent& e : s.history)
    out["history"].push_back({{"stamp_ns", e.stamp_ns}, {"what", printable(e.what)}, {"detail", printable(e.detail)}, {"revision", e.revision}, {"program", printable(e.program)}});
  return out;
}

}  // namespace periplus::model
