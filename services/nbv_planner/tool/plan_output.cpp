#include "services/nbv_planner/tool/plan_output.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "services/nbv_planner/tool/pose_text.h"

namespace periplus::nbv {
namespace {

constexpr double kPerDegree = std::numbers::pi / 180;

template <class... Arguments>
std::string format(const char* pattern, Arguments... arguments) {
  char text[400];
  std::snprintf(text, sizeof text, pattern, arguments...);
  return text;
}

// (yaw, pitch, roll) in degrees, without negative zeros.
Eigen::Vector3d degrees(const Pose& X_WC) {
  const Eigen::Vector3d ypr = camera_yaw_pitch_roll(X_WC) / kPerDegree;
  return (ypr.array().abs() < 1e-9).select(0.0, ypr);
}

const char* result_of(const Planned& p) {
  if (!p.no_view.empty()) return "no_reachable_view";
  return p.view.evaluation.gain.voxels > 0 ? "view" : p.view.cut_short ? "cut_short" : "nothing_unknown";
}

}  // namespace

std::string to_text(const PlanInput& input, const Planned& p) {
  const voxel::GridGeometry& g = input.situation.grid->geometry();
  std::string out = format("model     %s, revision %u, %zu views, %d x %d x %d voxels of %g m: %llu unknown, %llu known, %llu environment\n",
                           input.object_id.c_str(), input.situation.grid->revision, input.situation.views.size(), g.size.x(), g.size.y(), g.size.z(), g.voxel_size,
                           static_cast<unsigned long long>(p.counts.unknown), static_cast<unsigned long long>(p.counts.known),
                           static_cast<unsigned long long>(p.counts.environment));
  out += format("camera    %s, %s; scene %s; %zu forbidden\n", input.camera_name.c_str(),
                input.situation.rig.baseline > 0 ? format("a pair %g m apart", input.situation.rig.baseline).c_str() : "one camera",
                input.scene_name.c_str(), input.situation.forbidden.size());
  if (!p.no_view.empty()) return out + "no view   " + p.no_view + "\n";
  const PlannedView& v = p.view;
  const Eigen::Vector3d at = v.X_WC.translation(), ypr = degrees(v.X_WC);
  const Eigen::Quaterniond q(v.X_WC.linear());
  if (v.evaluation.gain.voxels == 0) out += v.cut_short ? "result    no gain found in the time given\n" : "result    nothing unknown is left to see\n";
  out += format("position  %.4f %.4f %.4f m\n", at.x(), at.y(), at.z());
  out += format("direction yaw %.2f  pitch %.2f  roll %.2f degrees (pitch positive down)\n", ypr.x(), ypr.y(), ypr.z());
  out += format("rotation  %.6f %.6f %.6f %.6f (w x y z of the optical frame: x right, y down, z forward)\n", q.w(), q.x(), q.y(), q.z());
  out += "pose      " + to_text(v.X_WC) + " (as --forbid takes it)\n";
  out += format("gain      %d unknown voxels, %llu pixels%s\n", v.evaluation.gain.voxels, static_cast<unsigned long long>(v.evaluation.gain.pixels),
                input.situation.rig.baseline > 0 ? ", by both eyes" : "");
  out += "terms    ";
  int column = 0;
  for (const auto& [name, value] : v.terms) out += format("%s%s %.6g", column++ % 6 == 0 && column > 1 ? "\n          " : " ", name.c_str(), value);
  out += format("\n          landmark term %s\n", v.landmark_term ? "on" : "off (too few stored features)");
  out += format("search    %s, seed %llu: %d evaluations, %.3f s%s (", p.method.c_str(), static_cast<unsigned long long>(p.seed), v.evaluations,
                p.seconds, v.cut_short ? ", cut short by the time limit" : "");
  column = 0;
  for (const auto& [name, seconds] : v.seconds) out += format("%s%s %.3f", column++ ? ", " : "", name.c_str(), seconds);
  return out + ")\n";
}

std::string to_json(const PlanInput& input, const Planned& p) {
  const voxel::GridGeometry& g = input.situation.grid->geometry();
  nlohmann::ordered_json j;
  j["schema"] = "periplus-nbv-1";
  j["result"] = result_of(p);
  j["model"] = {{"object", input.object_id}, {"revision", input.situation.grid->revision}, {"views", input.situation.views.size()}, {"voxel_m", g.voxel_size},
                {"size", {g.size.x(), g.size.y(), g.size.z()}}, {"unknown", p.counts.unknown}, {"known", p.counts.known},
                {"empty", p.counts.empty}, {"environment", p.counts.environment}};
  j["camera"] = {{"name", input.camera_name}, {"baseline_m", input.situation.rig.baseline}};
  j["scene"] = input.scene_name;
  nlohmann::ordered_json forbidden = nlohmann::ordered_json::array();
  for (const Pose& F : input.situation.forbidden) forbidden.push_back(to_text(F));
  j["forbidden"] = forbidden;
  j["method"] = p.method;
  j["seed"] = p.seed;
  if (!p.no_view.empty()) {
    j["reason"] = p.no_view;
    return j.dump(2) + "\n";
  }
  const PlannedView& v = p.view;
  const Eigen::Vector3d at = v.X_WC.translation(), ypr = degrees(v.X_WC);
  const Eigen::Quaterniond q(v.X_WC.linear());
  j["view"] = {{"position_m", {at.x(), at.y(), at.z()}}, {"yaw_deg", ypr.x()}, {"pitch_deg", ypr.y()}, {"roll_deg", ypr.z()},
               {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}, {"text", to_text(v.X_WC)}};
  j["gain"] = {{"voxels", v.evaluation.gain.voxels}, {"pixels", v.evaluation.gain.pixels}};
  j["f_e"] = v.f_e;
  nlohmann::ordered_json terms, seconds;
  for (const auto& [name, value] : v.terms) terms[name] = value;
  for (const auto& [name, value] : v.seconds) seconds[name] = value;
  seconds["all"] = p.seconds;
  j["terms"] = terms;
  j["landmark_term"] = v.landmark_term;
  j["evaluations"] = v.evaluations;
  j["cut_short"] = v.cut_short;
  j["seconds"] = seconds;
  return j.dump(2) + "\n";
}

}  // namespace periplus::nbv
