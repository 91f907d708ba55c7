#include "services/model_server/settings.h"

#include <cmath>
#include <cstdlib>

#include "common/core/error.h"

namespace periplus::model {

ModelSettings read_settings(const config::Node& root) {
  ModelSettings s;
  root.read("store_folder", s.store_folder);
  double wait_s = 2;
  root.read("perception_wait_s", wait_s, {.minimum = 0, .maximum = 60});
  s.perception_wait = std::chrono::milliseconds(std::lround(wait_s * 1000));
  root.read("perceptions_kept", s.perceptions_kept, {.minimum = 1, .maximum = 64});
  root.read("ros_topics", s.ros_topics);

  object_model::CarvingSettings& c = s.carving;
  const config::Node carving = root.child("carving");
  std::string mode = "conservative";
  carving.read_choice("mode", mode, {"conservative", "probabilistic"});
  c.mode = mode == "probabilistic" ? object_model::CarvingMode::probabilistic : object_model::CarvingMode::conservative;
  carving.read("margin_voxels", c.margin_voxels);
  carving.read("gap_px", c.gap_px);
  carving.read("cautious_share", c.cautious_share);
  carving.read("cautious_votes", c.cautious_votes);
  carving.read("uncertain_pose_m", c.uncertain_pose_m);
  carving.read("uncertain_pose_voxels", c.uncertain_pose_voxels);
  carving.read("uncertain_margin_voxels", c.uncertain_margin_voxels);
  carving.read("solid_extra_voxels", c.solid_extra_voxels);
  carving.read("solid_tolerance_m", c.solid_tolerance_m);
  object_model::LogOddsSettings& o = c.log_odds;
  const config::Node log_odds = root.child("log_odds");
  log_odds.read("hit", o.hit);
  log_odds.read("miss", o.miss);
  log_odds.read("least", o.least);
  log_odds.read("most", o.most);
  log_odds.read("empty_below", o.empty_below);
  log_odds.read("known_above", o.known_above);
  log_odds.read("disparity_sigma_px", o.disparity_sigma_px);
  log_odds.read("support_share", o.support_share);
  log_odds.read("support_voxels", o.support_voxels);
  const config::Node labels = root.child("labels");
  labels.read("known_points", c.known_points);
  labels.read("seen_points", c.seen_points);
  const config::Node surface = root.child("surface");
  surface.read("truncation_voxels", c.truncation_voxels);
  const config::Node growth = root.child("growth");
  growth.read("enabled", s.growth.enabled);
  growth.read("least_voxels", s.growth.least_voxels);
  growth.read("margin_voxels", s.growth.margin_voxels);
  growth.read("least_area", s.growth.least_area);
  object_model::LandmarkSettings& l = s.landmarks;
  const config::Node landmarks = root.child("landmarks");
  landmarks.read("most_distance", l.matching.most_distance);
  landmarks.read("most_bits", l.matching.most_bits);
  landmarks.read("ratio", l.matching.ratio);
  landmarks.read("distance_m", l.matching.distance_m);
  landmarks.read("distance_share", l.matching.distance_share);
  landmarks.read("coherent_share", l.matching.coherent_share);
  landmarks.read("least_coherent", l.matching.least_coherent);
  landmarks.read("most", l.matching.most);
  landmarks.read("reach_m", l.reach_m);
  landmarks.read("most_turn_rad", l.most_turn);
  root.finish();
  c.check();
  s.growth.check();
  l.check();
  return s;
}

std::string default_store_folder(int domain) {
  const std::string leaf = "/periplus/domain-" + std::to_string(domain);
  if (const char* state = std::getenv("XDG_STATE_HOME"); state && *state) return state + leaf;
  const char* home = std::getenv("HOME");
  require(home && *home, ErrorCode::bad_input, "store_folder is empty and neither XDG_STATE_HOME nor HOME is set; set store_folder");
  return std::string(home) + "/.local/state" + leaf;
}

}  // namespace periplus::model
