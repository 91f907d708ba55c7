#include "integration-tests/eyes_benchmark/report.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

namespace periplus::eyes_benchmark {
namespace {

using nlohmann::json;

json of(const Spread& s) { return {{"mean", s.mean}, {"median", s.median}, {"p95", s.p95}, {"count", s.count}}; }

json of(const StereoQuality& q) {
  return {{"pixels", q.pixels}, {"valid", q.valid}, {"surface", q.surface}, {"bad_1", q.bad_1}, {"bad_2", q.bad_2}, {"sigma_px", q.sigma_px}, {"error_m", of(q.error)}, {"behind", q.behind}};
}

json of(const DisparityQuality& q) { return {{"pixels", q.pixels}, {"covered", q.covered}, {"bad_1", q.bad_1}, {"bad_2", q.bad_2}}; }

json of(const ModelQuality& q) {
  return {{"covered_1_5_voxels", q.covered_1_5},
          {"covered_1_voxel", q.covered_1},
          {"error_m", of(q.error)},
          {"inside", q.inside},
          {"inside_emptied", q.inside_emptied},
          {"touching", q.touching},
          {"touching_emptied", q.touching_emptied},
          {"ghosts", q.ghosts}};
}

json of(const LabelQuality& q) {
  return {{"known", q.known}, {"known_hidden", q.known_hidden}, {"plain", q.plain}, {"plain_unknown", q.plain_unknown}, {"plain_emptied", q.plain_emptied}};
}

void lines(std::string& out, const std::string& prefix, const json& values, const std::string& name = "") {
  for (const auto& [key, value] : values.items()) {
    const std::string measure = name.empty() ? key : name + "." + key;
    if (value.is_object())
      lines(out, prefix, value, measure);
    else if (value.is_number())
      out += prefix + measure + "," + value.dump() + "\n";
  }
}

std::string stereo_table(const BenchmarkResult& r, const std::string& pictures) {
  std::string out =
      "## Stereo\n\nLeft eye, pixels of the object, six views. `behind`: of these pixels, where space would be carved more than 5 mm behind the "
      "true surface, after the minimum over a voxel's projection. Sigma: root mean square of the disparity errors up to 2 px; "
      "`disparity_sigma_px` of the configuration should not be less. Normals: angle to the true face, where there is a depth. Plain: "
      "`cv::StereoSGBM` with the settings of its documentation; its time is one eye's disparity, ours the whole pair with both eyes' depth, "
      "normals and features, in brackets that of all threads together. Filled: ours with its guesses (Algorithm 2), which are flagged and never carve.\n\n"
      "| object | texture | | valid, % | bad-1, % | bad-2, % | sigma, px | median, mm | p95, mm | behind, % | normals, median / p95, deg | ms a pair (processor) |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const StereoRow& row : r.stereo) {
    const StereoQuality &a = row.ours, &b = row.plain;
    out += fmt::format("| {} | {} | ours | {:.1f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.4f} | {:.1f} / {:.1f} | {:.0f} ({:.0f}) |\n", row.object, row.paint, 100 * a.valid,
                       100 * a.bad_1, 100 * a.bad_2, a.sigma_px, 1000 * a.error.median, 1000 * a.error.p95, 100 * a.behind, kDegrees * row.normals.median, kDegrees * row.normals.p95,
                       1000 * row.seconds, 1000 * row.processor_seconds);
    out += fmt::format("| | | plain | {:.1f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | | | {:.0f} |\n", 100 * b.valid, 100 * b.bad_1, 100 * b.bad_2, b.sigma_px, 1000 * b.error.median,
                       1000 * b.error.p95, 1000 * row.plain_seconds);
    const StereoQuality& c = row.filled;
    out += fmt::format("| | | filled | {:.1f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | | | |\n", 100 * c.valid, 100 * c.bad_1, 100 * c.bad_2, c.sigma_px, 1000 * c.error.median, 1000 * c.error.p95);
  }
  out += "\nLeast share of the object's pixels with texture, and least silhouette_valid_share, over the views:";
  for (const StereoRow& row : r.stereo) out += fmt::format(" {} {} {:.0f} / {:.0f} %;", row.object, row.paint, 100 * row.textured, 100 * row.shown_valid);
  out.back() = '.';
  out += "\n";
  for (const StereoRow& row : r.stereo)
    if (row.refused > 0)
      out += fmt::format("\n{}, texture {}: {} of six views were refused, as too little of them could be matched; they carve nothing.\n", row.object, row.paint, row.refused);
  if (pictures.empty()) return out;
  out += "\nDepth (near red, far blue) and error (white none, red 10 mm behind, blue 10 mm before, black without depth) of the first views:\n\n";
  for (const StereoRow& row : r.stereo)
    out += fmt::format("{0}, {1}: ![depth]({2}{0}_{1}_depth.png) ![error]({2}{0}_{1}_error.png)\n\n", row.object, row.paint, pictures);
  return out;
}

std::string model_table(const BenchmarkResult& r, const BenchmarkOptions& o, const std::string& pictures) {
  std::string out = fmt::format(
      "## Carved from six views\n\nCovered: share of the surface that can be seen from around with a known voxel's centre within 1.5 / 1 voxels. Error: of the "
      "model's surface. Emptied: of the voxels with their centre in the object, and of those that its surface passes through. Ghosts: voxels left standing "
      "wholly outside, of the object's volume (much of it nobody can see). Hidden: known voxels that no eye's ray reaches before the object stops it, of the known "
      "ones. Missed: voxels that stay unknown or (the other number) were emptied though an eye saw their surface plainly, ten pixels with a depth within 60° of its normal, of those seen so. Wrong disparities: {:.0f} % of the matched pixels have any disparity of the range. "
      "Wrong pose: the third view stands {:.0f} cm beside where it is said to.\n\n"
      "| object | texture | voxel, mm | depth by | mode | covered 1.5 / 1, % | error mean / p95, mm | inside emptied | touching emptied, % | ghosts, % | hidden, % | missed unknown / emptied, % | s |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      100 * o.wrong_share, 100 * o.wrong_pose_m);
  for (const ModelRow& row : r.models) {
    const ModelQuality& q = row.quality;
    out += fmt::format("| {} | {} | {:.0f} | {} | {} | {:.1f} / {:.1f} | {:.2f} / {:.2f} | {} of {} | {:.2f} | {:.1f} | {:.2f} | {:.2f} / {:.2f} | {:.2f} |\n", row.object, row.paint, 1000 * row.voxel_m, row.source, to_string(row.mode),
                       100 * q.covered_1_5, 100 * q.covered_1, 1000 * q.error.mean, 1000 * q.error.p95, q.inside_emptied, q.inside, 100 * q.touching_emptied_share(),
                       100 * q.ghosts, 100 * row.labels.hidden_share(), 100 * row.labels.plain_unknown_share(), 100 * row.labels.plain_emptied_share(), row.seconds);
  }
  if (pictures.empty()) return out;
  out += "\nThe model's surface from the first view, and its error along the optical axis:\n\n";
  for (const ModelRow& row : r.models) {
    if (row.quality.error.count == 0) continue;
    out += fmt::format("{0}, {1}, {2:.0f} mm, {3}, {6}: ![depth]({4}{5}_depth.png) ![error]({4}{5}_error.png)\n\n", row.object, row.paint, 1000 * row.voxel_m, row.source, pictures,
                       model_picture(row), to_string(row.mode));
  }
  return out;
}

json of(const MatchQuality& q) {
  return {{"degrees", q.degrees}, {"matches", q.matches}, {"right", q.right}, {"possible", q.possible}, {"precision", q.precision()}, {"recall", q.recall()}};
}

json of(const LandmarkQuality& q) {
  return {{"landmarks", q.landmarks}, {"joined", q.joined}, {"pure", q.pure}, {"observations", q.observations}, {"purity", q.purity()}};
}

std::string feature_table(const BenchmarkResult& r) {
  if (r.features.empty()) return "";
  std::string out = fmt::format(
      "## Features\n\nRich texture; a view and those turned from it about the object. Place: distance to the true place along the ray. Turned: matches by Algorithm 6, of "
      "these right (true places within {:.0f} mm), and right ones of all that the two views share. Landmarks: joined from two views or more, and of these with "
      "observations of one spot only. Selection: descriptor_first is Algorithm 5, geometry_first Algorithm 4. Bold: as configured.\n\n"
      "| object | features | selection | a view | place median / p95, mm |",
      1000 * kSameSpot);
  std::string rule = "|---|---|---|---|---|";
  for (const MatchQuality& q : r.features.front().turns) {
    out += fmt::format(" {:g}°: matches, right, found, % |", q.degrees);
    rule += "---|";
  }
  out += " joined landmarks, pure % | ms a pair |\n" + rule + "---|---|\n";
  for (const FeatureRow& row : r.features) {
    const char* mark = row.chosen ? "**" : "";
    out += fmt::format("| {} | {}{}{} | {}{}{} | {:.0f} | {:.2f} / {:.2f} |", row.object, mark, row.detector, mark, mark, row.selection, mark, row.features, 1000 * row.place.median,
                       1000 * row.place.p95);
    for (const MatchQuality& q : row.turns) out += fmt::format(" {}, {:.1f}, {:.1f} |", q.matches, 100 * q.precision(), 100 * q.recall());
    out += fmt::format(" {}, {:.1f} | {:.0f} |\n", row.landmarks.joined, 100 * row.landmarks.purity(), 1000 * row.seconds);
  }
  return out;
}

std::string real_table(const BenchmarkResult& r, const std::string& pictures) {
  if (r.real.empty()) return "";
  std::string out =
      "## Real pairs\n\nPixels with a true disparity that lie right of numDisparities, where plain matching can find something. Covered: of these pixels. "
      "Bad: of the covered ones. Time of ours: both eyes' disparities; of filling beside it. Filled: ours with its guesses (Algorithm 2), which are flagged "
      "and never carve. The last two of each pair: over the pixels that ours and plain both match.\n\n"
      "| pair | | covered, % | bad-1, % | bad-2, % | ms |\n|---|---|---|---|---|---|\n";
  for (const RealRow& row : r.real) {
    const auto line = [&](const std::string& pair, const char* what, const DisparityQuality& q, const std::string& ms) {
      out += fmt::format("| {} | {} | {:.1f} | {:.2f} | {:.2f} | {} |\n", pair, what, 100 * q.covered, 100 * q.bad_1, 100 * q.bad_2, ms);
    };
    line(row.name, "ours", row.ours, fmt::format("{:.0f}", 1000 * row.seconds));
    line("", "filled", row.filled, fmt::format("{:.0f}", 1000 * row.filling_seconds));
    line("", "plain", row.plain, fmt::format("{:.0f}", 1000 * row.plain_seconds));
    line("", "ours where both", row.ours_where_both, "");
    line("", "plain where both", row.plain_where_both, "");
  }
  if (pictures.empty()) return out;
  out += "\nDisparity and its error (white none, red and blue 4 px, grey: truth unknown):\n\n";
  for (const RealRow& row : r.real)
    out += fmt::format("{0}: ![disparity]({1}{0}_disparity.png) ![filled]({1}{0}_filled.png) ![error]({1}{0}_error.png)\n\n", row.name, pictures);
  return out;
}

std::string check_table(const std::vector<Check>& checks) {
  std::string out = "## Limits\n\n| | value | limit | |\n|---|---|---|---|\n";
  for (const Check& c : checks)
    out += fmt::format("| {} | {} {} | {} {:g} {} | {} |\n", c.name, c.known ? fmt::format("{:.4g}", c.value) : "missing", c.known ? c.unit : "", c.comparison, c.limit, c.unit,
                       c.ok ? "holds" : c.judged ? "**missed**" : "missed (not judged)");
  return out;
}

json parameters(const BenchmarkOptions& o) {
  const StereoRig rig = robot_eyes();
  const vision::MatchSettings& m = o.perceive.match;
  return {{"width", rig.camera.width},
          {"height", rig.camera.height},
          {"focal_length_px", rig.camera.fx},
          {"baseline_m", rig.baseline},
          {"distance_m", kDistance},
          {"noise_grey", o.sensor.noise},
          {"right_gain", o.sensor.right_gain},
          {"right_offset_grey", o.sensor.right_offset},
          {"longest_side_m", o.longest_side},
          {"seed", o.sensor.seed},
          {"threads", o.threads},
          {"repeats", o.repeats},
          {"surface_samples", o.surface_samples},
          {"touching_samples", o.touching_samples},
          {"wrong_share", o.wrong_share},
          {"wrong_pose_m", o.wrong_pose_m},
          {"turns_deg", o.turns},
          {"matching",
           {{"block_px", m.block},
            {"penalty_1", m.penalty_1},
            {"penalty_2", m.penalty_2},
            {"uniqueness_percent", m.uniqueness_percent},
            {"speckle_window_px", m.speckle_window},
            {"left_right_px", m.left_right_px}}},
          {"margin_voxels", o.carving.margin_voxels}};
}

}  // namespace

json to_json(const BenchmarkResult& r, const BenchmarkOptions& o, const std::vector<Check>& checks, const nbv_benchmark::Provenance& p) {
  json j;
  j["made"] = {{"version", p.version},   {"commit", p.commit},       {"date", p.date}, {"machine", p.machine},
               {"compiler", p.compiler}, {"libraries", p.libraries}, {"simd", p.simd}, {"command", p.command}};
  j["parameters"] = parameters(o);
  for (const StereoRow& row : r.stereo) {
    json steps;
    for (const auto& [step, time] : row.steps) steps[step] = time;
    j["stereo"].push_back({{"object", row.object},
                           {"texture", row.paint},
                           {"ours", of(row.ours)},
                           {"plain", of(row.plain)},
                           {"filled", of(row.filled)},
                           {"normals_rad", of(row.normals)},
                           {"normals_share", row.normals_share},
                           {"textured", row.textured},
                           {"silhouette_valid_share", row.shown_valid},
                           {"refused", row.refused},
                           {"seconds", {{"pair", row.seconds}, {"processor", row.processor_seconds}, {"plain", row.plain_seconds}, {"steps", steps}}}});
  }
  for (const ModelRow& row : r.models)
    j["carved"].push_back({{"object", row.object}, {"texture", row.paint}, {"voxel_m", row.voxel_m}, {"source", row.source}, {"mode", to_string(row.mode)}, {"quality", of(row.quality)}, {"labels", of(row.labels)}, {"seconds", row.seconds}});
  for (const FeatureRow& row : r.features) {
    json turns = json::array();
    for (const MatchQuality& q : row.turns) turns.push_back(of(q));
    j["features"].push_back({{"object", row.object},
                             {"detector", row.detector},
                             {"selection", row.selection},
                             {"chosen", row.chosen},
                             {"features", row.features},
                             {"place_m", of(row.place)},
                             {"turns", turns},
                             {"landmarks", of(row.landmarks)},
                             {"seconds", row.seconds}});
  }
  for (const RealRow& row : r.real)
    j["real"].push_back({{"name", row.name},
                         {"package", row.source},
                         {"first_column", row.first_column},
                         {"ours", of(row.ours)},
                         {"plain", of(row.plain)},
                         {"filled", of(row.filled)},
                         {"where_both", {{"ours", of(row.ours_where_both)}, {"plain", of(row.plain_where_both)}}},
                         {"seconds", {{"ours", row.seconds}, {"filling", row.filling_seconds}, {"plain", row.plain_seconds}}}});
  j["checks"] = to_json(checks);
  j["seconds"] = r.seconds;
  return j;
}

std::string to_csv(const BenchmarkResult& r) {
  std::string out = "table,object,texture,voxel_m,source,measure,value\n";
  for (const StereoRow& row : r.stereo) {
    const std::string head = "stereo," + row.object + "," + row.paint + ",,";
    lines(out, head + "ours,", of(row.ours));
    lines(out, head + "ours,", {{"normals_rad", of(row.normals)}, {"textured", row.textured}, {"silhouette_valid_share", row.shown_valid}, {"refused", row.refused}, {"seconds", row.seconds}});
    lines(out, head + "plain,", of(row.plain));
    lines(out, head + "plain,", {{"seconds", row.plain_seconds}});
    lines(out, head + "filled,", of(row.filled));
  }
  for (const ModelRow& row : r.models) {
    const std::string head = fmt::format("carved,{},{},{},\"{}, {}\",", row.object, row.paint, row.voxel_m, row.source, to_string(row.mode));
    lines(out, head, of(row.quality));
    lines(out, head, of(row.labels), "labels");
  }
  for (const FeatureRow& row : r.features) {
    const std::string head = fmt::format("features,{},rich,,{} {},", row.object, row.detector, row.selection);
    lines(out, head, {{"features", row.features}, {"place_m", of(row.place)}, {"landmarks", of(row.landmarks)}, {"seconds", row.seconds}});
    for (const MatchQuality& q : row.turns) lines(out, head, of(q), fmt::format("turned_{:g}", q.degrees));
  }
  for (const RealRow& row : r.real) {
    lines(out, "real," + row.name + ",,,ours,", of(row.ours));
    lines(out, "real," + row.name + ",,,plain,", of(row.plain));
    lines(out, "real," + row.name + ",,,filled,", of(row.filled));
    lines(out, "real," + row.name + ",,,ours where both,", of(row.ours_where_both));
    lines(out, "real," + row.name + ",,,plain where both,", of(row.plain_where_both));
  }
  return out;
}

std::string to_markdown(const BenchmarkResult& r, const BenchmarkOptions& o, const std::vector<Check>& checks, const nbv_benchmark::Provenance& p,
                        const std::string& pictures) {
  const StereoRig rig = robot_eyes();
  return fmt::format(
             "# The eyes and the carving, measured\n\n"
             "Rendered pairs, {} x {}, f = {:.0f} px, baseline {:.0f} mm, noise {:g} grey levels, right eye gain {:g} offset {:+g}, {:g} m to the object's middle, "
             "longest side {:g} m. Seed {}, {} threads.\n\n"
             "Made {} at {} ({}) on {}; {}, {}; `{}`; {:.0f} s.\n\n",
             rig.camera.width, rig.camera.height, rig.camera.fx, 1000 * rig.baseline, o.sensor.noise, o.sensor.right_gain, o.sensor.right_offset, kDistance, o.longest_side,
             o.sensor.seed, o.threads, p.date, p.commit, p.version, p.machine, p.compiler, p.libraries, p.command, r.seconds) +
         stereo_table(r, pictures) + "\n" + model_table(r, o, pictures) + "\n" + feature_table(r) + "\n" + real_table(r, pictures) + "\n" + check_table(checks);
}

}  // namespace periplus::eyes_benchmark
