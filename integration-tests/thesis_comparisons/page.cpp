#include "integration-tests/thesis_comparisons/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "integration-tests/thesis_comparisons/chart.h"

namespace periplus::thesis_comparisons {
namespace {

using nlohmann::json;

Verdict verdict(bool agrees, bool in_part) { return agrees ? Verdict::agrees : in_part ? Verdict::in_part : Verdict::disagrees; }

double percent(double share) { return 100 * share; }

// Mean quality where begin and end satisfy `which`.
double mean_quality(const TrustRegion& t, const std::function<bool(double begin, double end)>& which) {
  double sum = 0;
  int n = 0;
  for (std::size_t b = 0; b < t.begin.size(); ++b) {
    for (std::size_t e = 0; e < t.end.size(); ++e) {
      if (!which(t.begin[b], t.end[e])) continue;
      sum += t.quality[b][e];
      ++n;
    }
  }
  return n == 0 ? 0 : sum / n;
}

// Poses to a level with pixels and with the mixed quantification, mean over objects and seeds; the least ratio.
struct Poses {
  double pixels = 0, voxels = 0, mixed = 0;
  double most_saved = 0;   // of one object and seed, mixed against pixels
};
Poses poses_to(const Quantifications& q, int LargeRun::* level) {
  Poses p;
  std::map<std::pair<std::string, std::uint64_t>, std::map<std::string, double>> by;
  for (const LargeRun& r : q.runs) by[{r.object, r.seed}][r.quantification] = r.*level;
  for (const auto& [key, of] : by) {
    const double n = static_cast<double>(by.size());
    p.pixels += of.at("pixels") / n;
    p.voxels += of.at("voxels") / n;
    p.mixed += of.at("mixed") / n;
    p.most_saved = std::max(p.most_saved, 1 - of.at("mixed") / of.at("pixels"));
  }
  return p;
}

double mean_distance(const Quantifications& q, const std::string& quantification) {
  double sum = 0;
  int n = 0;
  for (const LargeRun& r : q.runs) {
    if (r.quantification != quantification) continue;
    for (std::size_t i = 1; i < r.distance.size(); ++i, ++n) sum += r.distance[i];  // the first is given
  }
  return n == 0 ? 0 : sum / n;
}

// Share known after that share of the poses.
double mean_known(const Quantifications& q, const std::string& quantification, double share) {
  double sum = 0;
  int n = 0;
  for (const LargeRun& r : q.runs) {
    if (r.quantification != quantification || r.known.empty()) continue;
    sum += r.known[std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(r.known.size()))) - 1];
    ++n;
  }
  return n == 0 ? 0 : sum / n;
}

std::string short_number(double v) { return fmt::format("{:g}", v); }

}  // namespace

const char* to_string(Verdict v) { return v == Verdict::agrees ? "agrees" : v == Verdict::in_part ? "in part" : "disagrees"; }

std::vector<Claim> claims(const Comparisons& c) {
  std::vector<Claim> all;
  {
    const Poses to90 = poses_to(c.quantifications, &LargeRun::poses_to_90), to95 = poses_to(c.quantifications, &LargeRun::poses_to_95);
    const double saved = std::max(1 - to90.mixed / to90.pixels, 1 - to95.mixed / to95.pixels);
    all.push_back({"3.4.1 quantification",
                   "Pixels alone set the robot too close to a large object; the mixed quantification needs up to 40 % fewer poses on objects of about 4 m.",
                   fmt::format("Poses to 90 % of the surface: {:.1f} by pixels, {:.1f} by voxels, {:.1f} mixed; to 95 %: {:.1f}, {:.1f}, {:.1f}. Mixed saves {:.0f} % at "
                               "90 %, {:.0f} % at 95 % on average, {:.0f} % at most. Mean distance {:.2f} m by pixels, {:.2f} m by voxels, {:.2f} m mixed. After a third of the poses pixels know {:.0f} %, mixed {:.0f} %; "
                               "after all of them {:.0f} and {:.0f} %.",
                               to90.pixels, to90.voxels, to90.mixed, to95.pixels, to95.voxels, to95.mixed, percent(1 - to90.mixed / to90.pixels),
                               percent(1 - to95.mixed / to95.pixels), percent(std::max(to90.most_saved, to95.most_saved)),
                               mean_distance(c.quantifications, "pixels"), mean_distance(c.quantifications, "voxels"), mean_distance(c.quantifications, "mixed"), percent(mean_known(c.quantifications, "pixels", 1.0 / 3)),
                               percent(mean_known(c.quantifications, "mixed", 1.0 / 3)), percent(mean_known(c.quantifications, "pixels", 1)),
                               percent(mean_known(c.quantifications, "mixed", 1))),
                   verdict(saved > 0.1, saved > 0 || mean_distance(c.quantifications, "pixels") < mean_distance(c.quantifications, "mixed"))});
  }
  {
    const TrustRegion& t = c.trust_region;
    const auto fine = [](double e) { return e <= 0.01; };
    const double large = mean_quality(t, [&](double b, double e) { return b >= 1 && fine(e); });
    const double small = mean_quality(t, [&](double b, double e) { return b < 0.2 && fine(e); });
    const double middle = mean_quality(t, [&](double b, double e) { return b >= 0.2 && b < 1 && fine(e); });
    all.push_back({"3.4.2 rho_beg", "Better poses where rho_beg is equal or superior to the object's size.",
                   fmt::format("Mean score (1: the largest N_u) {:.3f} where rho_beg is 1 or 2 sizes, {:.3f} at 0.2 and 0.5, {:.3f} below.", large, middle, small),
                   verdict(large > middle && large > small, large > small)});
    const double coarse = mean_quality(t, [](double b, double e) { return b >= 0.2 && e > 0.01; });
    const double accurate = mean_quality(t, [](double b, double e) { return b >= 0.2 && e < 0.01; });
    const double at = mean_quality(t, [](double b, double e) { return b >= 0.2 && e == 0.01; });
    all.push_back({"3.4.2 rho_end", "Better poses where rho_end is smaller than a hundredth of the object's size.",
                   fmt::format("Mean score {:.3f} where rho_end is a tenth of the size, {:.3f} at a hundredth, {:.3f} below (rho_beg 0.2 sizes and more).", coarse, at, accurate),
                   verdict(accurate > coarse + 0.01 && accurate >= at, accurate > coarse)});
  }
  {
    double runs = 0, at_most = 0, farthest = 0, turned = 0, once = 0, iterated = 0, change = 0, largest = 0, found = 0;
    const double n = static_cast<double>(c.lines.size());
    for (const StartLine& l : c.lines) {
      runs += l.mean_runs / n;
      at_most += l.share_at_most / n;
      change += l.start_change / n;
      found += l.found_change / n;
      largest = std::max(largest, l.largest_start_change);
      farthest = std::max(farthest, l.farthest);
      turned = std::max(turned, l.turned);
      for (std::size_t i = 0; i < l.y.size(); ++i) {
        once += (l.start[i] - l.once[i]) / (n * static_cast<double>(l.y.size()));
        iterated += (l.once[i] - l.iterated[i]) / (n * static_cast<double>(l.y.size()));
      }
    }
    all.push_back({"3.4.2 the function along a line", "The function can change abruptly even with small variations of the starting pose; what NEWUOA finds differs from start to start.",
                   fmt::format("From one start to the next f_e changes by {:.1f} % of the largest N_u on average, {:.1f} % at most; what NEWUOA finds by {:.1f} % on average. N_u is computed exactly here, "
                               "without a raster's noise.",
                               percent(change), percent(largest), percent(found)),
                   verdict(largest > 0.2 && found > change, found > change)});
    all.push_back({"3.4.2 starting pose", "One run of NEWUOA improves the pose but is often stuck in a local minimum; runs that follow reach much better ones.",
                   fmt::format("One run lowers f_e by {:.0f} voxels on average, the runs that follow by {:.0f} more.", once, iterated),
                   verdict(once > 0 && iterated > 0.1 * once, once > 0 && iterated > 0)});
    all.push_back({"3.4.2 iterations", "5 iterations on average; the maximum of 10 is reached from 2 % of the starts. The camera moves up to 0.7 m and turns up to about 50 degrees.",
                   fmt::format("{:.1f} iterations, the maximum from {:.0f} %; up to {:.2f} m and {:.0f} degrees.", runs, percent(at_most), farthest, turned * 180 / std::numbers::pi),
                   verdict(runs > 3 && runs < 7 && at_most < 0.1, runs < 8)});
  }
  {
    const Sampling& s = c.sampling;
    all.push_back({"3.4.3 fixed sampling", "A fixed sampling of the six dimensions can give similar or better views with roughly as many samples.",
                   fmt::format("With {} evaluations each, the sampling is similar or better in {:.0f} % of {} cases (mean score {:.3f}, NEWUOA {:.3f}).", s.evaluations,
                               percent(s.fixed_similar_or_better), s.cases, s.fixed, s.newuoa),
                   verdict(s.fixed_similar_or_better > 0.3, s.fixed_similar_or_better > 0)});
    all.push_back({"3.4.3 local minima", "NEWUOA reaches a local minimum with fewer samples than a sampling of the local space; so the search samples roughly and refines by NEWUOA.",
                   fmt::format("To within 2 % of the minimum that one run of NEWUOA finds, it takes {:.0f} evaluations and a sampling of the space between start and minimum {:.0f} (medians; {} did not suffice in {:.0f} % of the cases). Sampling "
                               "and NEWUOA together: mean score {:.3f}, no worse than the better of the two alone in {:.0f} %.",
                               s.newuoa_evaluations, s.local_samples, s.most_samples, percent(s.not_reached), s.both, percent(s.both_best)),
                   verdict(s.newuoa_evaluations < s.local_samples && s.both >= std::max(s.fixed, s.newuoa), s.newuoa_evaluations < s.local_samples || s.both >= std::max(s.fixed, s.newuoa))});
  }
  // The thesis' own rho_end of 3.4.7 stands in the middle.
  const Methods& m = c.methods[c.methods.size() / 2];
  const Method &newuoa = m.methods[0], &bobyqa = m.methods[1], &simplex = m.methods[2];
  std::string ratios;
  for (const Methods& each : c.methods) ratios += fmt::format("{}{:.1f} at rho_end {:g}", ratios.empty() ? "" : ", ", each.fewer_than_newuoa, each.rho_end);
  all.push_back({"3.4.4 BOBYQA: score", "Scores in a similar order of magnitude as NEWUOA's, and poses near the limits of height and angles that NEWUOA is driven away from.",
                 fmt::format("Mean N_u {:.3f} of the largest by BOBYQA, {:.3f} by NEWUOA; at least 90 % of NEWUOA's in {:.0f} % of {} cases. In the outer tenth of a range end {:.0f} % of BOBYQA's "
                             "results and {:.0f} % of NEWUOA's.",
                             bobyqa.voxels, newuoa.voxels, percent(m.bobyqa_similar), m.cases, percent(bobyqa.near_limit), percent(newuoa.near_limit)),
                 verdict(bobyqa.voxels > 0.8 * newuoa.voxels && bobyqa.near_limit > newuoa.near_limit, bobyqa.voxels > 0.5 * newuoa.voxels)});
  all.push_back({"3.4.4 BOBYQA: evaluations", "About 10 times fewer iterations than NEWUOA.",
                 fmt::format("NEWUOA takes {} times as many (median).", ratios),
                 verdict(m.fewer_than_newuoa > 5, m.fewer_than_newuoa > 2)});
  std::string more;
  for (const Methods& each : c.methods) more += fmt::format("{}{:.1f} at rho_end {:g}", more.empty() ? "" : ", ", each.simplex_more, each.rho_end);
  all.push_back({"3.4.5 simplex: score", "BOBYQA results in better scores overall; in a small number of cases the simplex is better.",
                 fmt::format("BOBYQA is better in {:.0f} %, the simplex in {:.0f} % of {} cases (by more than 1 %); mean score {:.3f} and {:.3f}.", percent(m.bobyqa_better),
                             percent(m.simplex_better), m.cases, bobyqa.quality, simplex.quality),
                 verdict(bobyqa.quality > simplex.quality && m.bobyqa_better > m.simplex_better, m.bobyqa_better > 0.8 * m.simplex_better)});
  all.push_back({"3.4.5 simplex: evaluations", "The simplex tests 2 to 10 times as many poses.",
                 fmt::format("The simplex takes {} times as many (median).", more), verdict(m.simplex_more >= 2 && m.simplex_more <= 10, m.simplex_more > 1.2)});
  return all;
}

json to_json(const Comparisons& c, const ComparisonOptions& o, const nbv_benchmark::Provenance& made) {
  json j;
  j["schema"] = "periplus-thesis-comparisons-1";
  j["made"] = {{"version", made.version}, {"commit", made.commit}, {"date", made.date}, {"machine", made.machine}, {"compiler", made.compiler},
               {"libraries", made.libraries}, {"simd", made.simd}, {"command", made.command}};
  j["parameters"] = {{"size_m", o.size}, {"voxels", o.voxels}, {"starts", o.starts}, {"line_steps", o.line_steps}, {"seed", o.seed}, {"large_size_m", o.large_size},
                     {"large_voxels", o.large_voxels}, {"large_evaluations", o.large_evaluations}, {"large_views", o.large_views}, {"large_seeds", o.large_seeds}};
  j["objects"] = c.objects;
  const TrustRegion& t = c.trust_region;
  j["trust_region"] = {{"cases", t.cases}, {"rho_begin_sizes", t.begin}, {"rho_end_sizes", t.end}, {"score", t.quality}, {"evaluations", t.evaluations}};
  for (const StartLine& l : c.lines)
    j["starting_pose"].push_back({{"object", l.object}, {"y_m", l.y}, {"start", l.start}, {"once", l.once}, {"iterated", l.iterated}, {"mean_runs", l.mean_runs},
                                  {"share_at_most", l.share_at_most}, {"farthest_m", l.farthest}, {"turned_rad", l.turned}, {"start_change", l.start_change}, {"largest_start_change", l.largest_start_change},
                                  {"found_change", l.found_change}});
  const Sampling& s = c.sampling;
  j["sampling"] = {{"cases", s.cases}, {"evaluations", s.evaluations}, {"score_newuoa", s.newuoa}, {"score_fixed", s.fixed}, {"score_both", s.both},
                   {"fixed_similar_or_better", s.fixed_similar_or_better}, {"both_best", s.both_best}, {"median_newuoa_evaluations", s.newuoa_evaluations},
                   {"median_local_samples", s.local_samples}, {"not_reached", s.not_reached}, {"most_samples", s.most_samples}};
  for (const Methods& m : c.methods) {
    json methods = json::array();
    for (const Method& r : m.methods)
      methods.push_back({{"name", r.name}, {"score", r.quality}, {"voxels", r.voxels}, {"evaluations", r.evaluations}, {"within", r.within}, {"near_limit", r.near_limit}});
    j["methods"].push_back({{"rho_end", m.rho_end}, {"cases", m.cases}, {"methods", methods}, {"bobyqa_similar", m.bobyqa_similar}, {"newuoa_over_bobyqa", m.fewer_than_newuoa},
                            {"bobyqa_better", m.bobyqa_better}, {"simplex_better", m.simplex_better}, {"simplex_over_bobyqa", m.simplex_more}});
  }
  for (const LargeRun& r : c.quantifications.runs)
    j["quantification"].push_back({{"object", r.object}, {"quantification", r.quantification}, {"seed", r.seed}, {"known", r.known}, {"distance_m", r.distance},
                                   {"poses_to_90", r.poses_to_90}, {"poses_to_95", r.poses_to_95}});
  for (const Claim& claim : claims(c))
    j["claims"].push_back({{"section", claim.section}, {"thesis", claim.thesis}, {"here", claim.here}, {"verdict", to_string(claim.verdict)}});
  return j;
}

std::vector<Figure> figures(const Comparisons& c) {
  std::vector<Figure> all;
  {
    std::map<std::string, std::vector<double>> sum;
    std::map<std::string, int> runs;
    std::size_t longest = 0;
    for (const LargeRun& r : c.quantifications.runs) longest = std::max(longest, r.known.size());
    for (const LargeRun& r : c.quantifications.runs) {
      auto& s = sum[r.quantification];
      s.resize(longest, 0);
      ++runs[r.quantification];
      for (std::size_t i = 0; i < longest && !r.known.empty(); ++i) s[i] += 100 * r.known[std::min(i, r.known.size() - 1)];
    }
    std::vector<Series> series;
    for (const char* name : {"pixels", "voxels", "mixed"}) {
      Series s{name, {}, {}};
      for (std::size_t i = 0; i < longest; ++i) {
        s.x.push_back(static_cast<double>(i + 1));
        s.y.push_back(sum[name][i] / std::max(1, runs[name]));
      }
      series.push_back(s);
    }
    all.push_back({"quantification.svg", line_chart("3.4.1: objects of 4 m, surface known after each pose, by quantification", {"poses"},
                                                    {"known, % of what any run came to know"}, series)});
  }
  {
    const TrustRegion& t = c.trust_region;
    std::vector<std::string> rows, columns;
    for (const double b : t.begin) rows.push_back(short_number(b));
    for (const double e : t.end) columns.push_back(short_number(e));
    all.push_back({"trust-region.svg", shaded_table("3.4.2, as Fig. 3.7: mean score of one run of NEWUOA (1: the largest N_u)", "rho_beg / size", rows, "rho_end / size", columns, t.quality, 3)});
    all.push_back({"trust-region-evaluations.svg", shaded_table("3.4.2: mean number of evaluations of one run", "rho_beg / size", rows, "rho_end / size", columns, t.evaluations, 0)});
  }
  if (!c.lines.empty()) {
    const StartLine& l = c.lines.front();
    all.push_back({"starting-pose.svg", line_chart("3.4.2, as Fig. 3.8: start poses along y in front of the " + l.object, {"y of the start [m]"}, {"f_e (smaller is better)"},
                                                   {{"starting pose", l.y, l.start}, {"NEWUOA once", l.y, l.once}, {"iterated", l.y, l.iterated}})});
  }
  {
    std::vector<Series> series;
    for (std::size_t k = 0; k < 3; ++k) {
      Series s{c.methods.front().methods[k].name, {}, {}};
      for (const Methods& m : c.methods) {
        s.x.push_back(m.rho_end);
        s.y.push_back(m.methods[k].evaluations);
      }
      series.push_back(s);
    }
    all.push_back({"evaluations.svg", line_chart("3.4.4 and 3.4.5: evaluations of one run from the same starts", {"rho_end [m, rad]", true}, {"evaluations, mean"}, series)});
  }
  return all;
}

std::string page(const Comparisons& c, const ComparisonOptions& o, const nbv_benchmark::Provenance& made, const std::string& folder) {
  std::string md =
      "# The thesis' comparisons, run again\n\n"
      "Made by `integration-tests/thesis_comparisons/run.sh`; every sentence and figure below is that program's own output.\n\n";
  md += fmt::format("Commit {}, {}; {}; {}; {}.\n\n", made.commit, made.date, made.machine, made.compiler, made.simd);
  std::string objects;
  for (const std::string& name : c.objects) objects += (objects.empty() ? "" : ", ") + name;
  md += fmt::format(
      "{} objects ({}) of {} m on a table, {} voxels along the box, carved by two looks with true depth; one camera of 640x480 and 25 degrees (4.1.1), height 1 to 1.39 m, "
      "pitch -25 to 60 and roll +-10 degrees (4.1.2), p = 6, gamma = 20, d_min = 0.6 m, more than 5 pixels a voxel (3.4.7), each penalty as large as the largest N_u where its constraint is "
      "violated (3.2.1.5), no landmarks. {} starts for each object, {} in all, are random poses around it that see something unknown. The search variables are x, y, z, yaw, pitch and roll "
      "in metres and radians, with one rho for all; where nothing else is said rho_beg is 0.4 and rho_end 1e-5. A score is -f_e divided by the largest N_u of 300 poses around the object, at "
      "least -1.\n\n",
      c.objects.size(), objects, short_number(o.size), o.voxels, o.starts, c.trust_region.cases);
  md += "| | the thesis | here | |\n|---|---|---|---|\n";
  for (const Claim& claim : claims(c)) md += fmt::format("| {} | {} | {} | **{}** |\n", claim.section, claim.thesis, claim.here, to_string(claim.verdict));
  md += fmt::format(
      "\n## 3.4.1 Quantification\n\n{} objects of {} m on the floor, {} first poses each, {} poses, the thesis' search with BOBYQA and {} evaluations a pose. *Known* is the share of the surface "
      "voxels that any of an object's runs came to know; a level that a run did not reach counts as one pose more than it had.\n\n![]({}/quantification.svg)\n\n",
      c.quantifications.runs.size() / static_cast<std::size_t>(3 * o.large_seeds), short_number(o.large_size), o.large_seeds, o.large_views, o.large_evaluations, folder);
  md += "| object | first pose | poses to 90 %: pixels, voxels, mixed | to 95 % |\n|---|---|---|---|\n";
  std::map<std::pair<std::string, std::uint64_t>, std::map<std::string, const LargeRun*>> by;
  for (const LargeRun& r : c.quantifications.runs) by[{r.object, r.seed}][r.quantification] = &r;
  const auto number = [](const LargeRun& r, int poses) { return poses > static_cast<int>(r.known.size()) ? fmt::format("> {}", r.known.size()) : std::to_string(poses); };
  for (const auto& [key, of] : by) {
    md += fmt::format("| {} | {} | {}, {}, {} | {}, {}, {} |\n", key.first, key.second, number(*of.at("pixels"), of.at("pixels")->poses_to_90),
                      number(*of.at("voxels"), of.at("voxels")->poses_to_90), number(*of.at("mixed"), of.at("mixed")->poses_to_90),
                      number(*of.at("pixels"), of.at("pixels")->poses_to_95), number(*of.at("voxels"), of.at("voxels")->poses_to_95),
                      number(*of.at("mixed"), of.at("mixed")->poses_to_95));
  }
  md += fmt::format("\n## 3.4.2 Trust region and starting pose\n\n![]({0}/trust-region.svg)\n\n![]({0}/trust-region-evaluations.svg)\n\n![]({0}/starting-pose.svg)\n\n", folder);
  md += "| object | iterations, mean | ten reached | moved at most [m] | turned at most [degrees] |\n|---|---|---|---|---|\n";
  for (const StartLine& l : c.lines)
    md += fmt::format("| {} | {:.1f} | {:.0f} % | {:.2f} | {:.0f} |\n", l.object, l.mean_runs, percent(l.share_at_most), l.farthest, l.turned * 180 / std::numbers::pi);
  md += fmt::format("\n## 3.4.4, 3.4.5 BOBYQA, NEWUOA, simplex\n\nSingle runs from the same starts. Scores without the interval terms, which BOBYQA and the simplex have as bounds.\n\n![]({}/evaluations.svg)\n\n", folder);
  md += "| rho_end | method | score | N_u / largest | evaluations | within the limits | near a limit |\n|---|---|---|---|---|---|---|\n";
  for (const Methods& m : c.methods)
    for (const Method& r : m.methods)
      md += fmt::format("| {:g} | {} | {:.3f} | {:.3f} | {:.0f} | {:.0f} % | {:.0f} % |\n", m.rho_end, r.name, r.quality, r.voxels, r.evaluations, percent(r.within), percent(r.near_limit));
  return md;
}

}  // namespace periplus::thesis_comparisons
