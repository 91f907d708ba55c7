#include "services/nbv_planner/settings.h"

#include <algorithm>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/core/error.h"
#include "common/core/hash.h"
#include "common/core/version.h"
#include "services/nbv_planner/reachability_table.h"

namespace periplus::nbv {
namespace {

template <class T>
void choose(const config::Node& node, const char* key, T& value, const std::vector<std::pair<std::string, T>>& choices) {
  std::vector<std::string> names;
  std::string name;
  for (const auto& [known, meaning] : choices) names.push_back(known);
  if (!node.read_choice(key, name, names)) return;
  value = std::find_if(choices.begin(), choices.end(), [&](const auto& c) { return c.first == name; })->second;
}

std::string digest_of_what_counts(const config::Node& root) {
  config::Node copy = config::parse(root.text(), "settings");
  for (const char* key : {"revision_wait_s", "other_instances", "search.threads"}) config::set(copy, key, "0");
  return sha256_hex(std::string(version()) + "\n" + copy.text());
}

void read_panorama(const config::Node& node, PanoramaSettings& s) {
  node.read("positions", s.positions, {1, 100000});
  node.read("rounds", s.rounds, {0, 20});
  node.read("kept", s.kept, {1, 1000});
  node.read("each", s.each, {1, 1000});
  node.read("radius_m", s.radius, {0.001, 10});
  node.read("wide", s.wide, {1, 1000});
  node.read("starts", s.starts, {1, 1000});
  node.read("position_evaluations", s.position_evaluations, {0, 1000});
  node.read("finalists", s.finalists, {1, 1000});
  node.read("final_evaluations", s.final_evaluations, {0, 1000});
  node.read("final_rounds", s.final_rounds, {0, 20});
  node.read("much_from", s.much_from, {0, 100000000});
  node.read("exact", s.exact, {0, 1000});
  node.read("exact_evaluations", s.exact_evaluations, {0, 10000});
}

std::shared_ptr<const Reachability> read_reachability(const config::Node& node) {
  std::vector<double> heights, pitches, shares;
  node.read("heights_m", heights);
  node.read("pitches_deg", pitches);
  node.read("shares", shares);
  if (heights.empty() && pitches.empty() && shares.empty()) return nullptr;
  for (double& pitch : pitches) pitch *= std::numbers::pi / 180;
  try {
    return std::make_shared<const ReachabilityTable>(std::move(heights), std::move(pitches), std::move(shares));
  } catch (const Error& e) {
    throw_error(ErrorCode::bad_input, node.where() + ": " + e.what());
  }
}

}  // namespace

Settings read_settings(const config::Node& root) {
  Settings s;
  root.read("revision_wait_s", s.revision_wait_s, {0, 60});
  root.read("other_instances", s.other_instances, {0, 64});

  const config::Node search = root.child("search");
  choose(search, "method", s.search.method, {{"fast", SearchMethod::fast}, {"thorough", SearchMethod::thorough}, {"thesis", SearchMethod::thesis}});
  search.read("max_evaluations", s.search.max_evaluations, {8, 1000000});
  search.read("threads", s.search.threads, {1, 64});
  const config::Node lookahead = search.child("lookahead");
  lookahead.read("depth", s.search.lookahead.depth, {1, 3});
  lookahead.read("discount", s.search.lookahead.discount, {0, 1});
  lookahead.read("within", s.search.lookahead.within, {0, 1});
  lookahead.read("candidates", s.search.lookahead.candidates, {2, 64});
  read_panorama(search.child("fast"), s.search.fast);
  read_panorama(search.child("thorough"), s.search.thorough);
  const config::Node thesis = search.child("thesis");
  ThesisSettings& t = s.search.thesis;
  choose(thesis, "local", t.local,
         {{"bobyqa", ThesisLocal::bobyqa}, {"newuoa", ThesisLocal::newuoa}, {"nelder_mead", ThesisLocal::nelder_mead}, {"none", ThesisLocal::none}});
  thesis.read("samples", t.samples, {1, 100000});
  thesis.read("starts", t.starts, {1, 1000});
  thesis.read("first_stage_runs", t.first_stage_runs, {1, 100});
  thesis.read("finalists", t.finalists, {1, 100});
  thesis.read("second_stage_runs", t.second_stage_runs, {1, 100});
  thesis.read("run_evaluations", t.run_evaluations, {15, 10000});
  thesis.read("trust_region_per_m", t.trust_region, {0.1, 1000});
  thesis.read("end_m", t.end, {1e-6, 0.1});

  const config::Node evaluation = root.child("evaluation");
  EvaluationSettings& e = s.evaluation;
  choose(evaluation, "quantification", e.quantification,
         {{"pixels", Quantification::pixels}, {"voxels", Quantification::voxels}, {"mixed", Quantification::mixed}});
  evaluation.read("pixels_per_voxel_share", e.pixels_per_voxel_share, {0, 1});
  evaluation.read("likely_within_voxels", e.likely_within, {0, 1000});
  evaluation.read("quality_weight", e.quality_weight, {0, 1000});
  evaluation.read("quality_reference_m", e.quality_reference, {0.01, 100});
  evaluation.read("interval_exponent", e.interval_exponent, {2, 20});
  require(e.interval_exponent % 2 == 0, ErrorCode::bad_input,
          evaluation.where() + ": interval_exponent must be even, so that both bounds are bounds");
  evaluation.read("distance_slope_per_m", e.distance_slope, {0, 1000});
  evaluation.read("landmarks", e.landmarks);
  evaluation.read("least_landmarks", e.least_landmarks, {1, 1000});
  evaluation.read("landmark_reward", e.landmark_reward, {0, 1000});
  evaluation.read("landmark_slope", e.landmark_slope, {0, 1000});
  evaluation.read("landmark_cosine", e.landmark_cosine, {-1, 1});
  evaluation.read("forbidden_slope", e.forbidden_slope, {0, 1000});
  evaluation.read("motion_per_m", e.motion_per_m, {0, 1000});
  evaluation.read("motion_per_rad", e.motion_per_rad, {0, 1000});
  choose(evaluation, "lambda_rule", e.lambda_rule,
         {{"capped", LambdaRule::capped}, {"scaled", LambdaRule::scaled}, {"fixed", LambdaRule::fixed}});
  evaluation.read("lambda_interval", e.lambda_interval, {0, 1e9});
  evaluation.read("lambda_motion", e.lambda_motion, {0, 1000});
  evaluation.read("lambda_reach", e.lambda_reach, {0, 1000});
  evaluation.read("lambda_distance", e.lambda_distance, {0, 1e9});
  evaluation.read("lambda_landmarks", e.lambda_landmarks, {0, 1e9});
  evaluation.read("lambda_forbidden", e.lambda_forbidden, {0, 1e9});
  evaluation.read("more_than_pixels", e.pair.more_than_pixels, {0, 100000});
  evaluation.read("pair_depth_min_m", e.pair.depth_min, {0, 100});
  evaluation.read("pair_depth_max_m", e.pair.depth_max, {0.01, 100});
  require(e.pair.depth_min < e.pair.depth_max, ErrorCode::bad_input,
          evaluation.where() + ": pair_depth_min_m must be less than pair_depth_max_m");

  const config::Node constraints = root.child("constraints");
  ConstraintSettings& c = s.constraints;
  constraints.read("head_radius_m", c.head_radius, {0.01, 1});
  constraints.read("base_behind_eyes_m", c.base_behind_eyes, {-1, 1});
  constraints.read("body_shrink_m", c.body_shrink, {0, 1});
  constraints.read("forbidden_distance_m", c.forbidden_distance, {0, 10});
  double degrees = c.forbidden_angle * 180 / std::numbers::pi;
  if (constraints.read("forbidden_angle_deg", degrees, {0, 180})) c.forbidden_angle = degrees * std::numbers::pi / 180;
  s.reachability = read_reachability(root.child("reachability"));
  root.finish();
  s.alike = digest_of_what_counts(root);
  return s;
}

}  // namespace periplus::nbv
