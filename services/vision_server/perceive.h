// From a rectified pair to a perception: the low level vision server's work (thesis 5.2.6, 4.2.1.2, 4.2.2.1).
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/object_model/perception.h"
#include "common/scene/scene.h"
#include "services/vision_server/depth.h"
#include "services/vision_server/features.h"
#include "services/vision_server/rectification.h"
#include "services/vision_server/stereo_matcher.h"
#include "services/vision_server/texture.h"

namespace periplus::vision {

struct PerceiveSettings {
  MatchSettings match;
  DepthSettings depth;
  TextureSettings texture;
  FeatureSettings features;
  double least_depth_m = 0.4;             // nothing nearer is searched for
  double default_far_m = 6.5;             // how far to search where no room is known
  double least_contrast = 5;              // grey levels, standard deviation: an eye below is blank
  double least_valid_share = 0.05;        // of the pixels in the box's silhouette
  double position_sigma_m = 0.001;        // of the camera pose as reported
  double rotation_sigma_rad = 0.001;
  void check() const;                     // throws Error(bad_input)
};

// What is known of the room; either may be nullptr.
struct Surroundings {
  const scene::Scene* scene = nullptr;               // how far to search
  const scene::CollisionWorld* solids = nullptr;     // what is not the object
};

struct PerceiveReport {
  double valid_share = 0;                 // matched, of all pixels of the left eye
  double valid_share_in_box = 0;          // of those that show the box
  double textured_share = 1;              // of those that show the object; 1 where too few can be told
  double noise = 0;                       // of the left image [grey levels]
  std::vector<std::pair<std::string, double>> seconds;  // by step; those of the right eye's depth and features pass meanwhile
};

// Perception with both eyes' depth. `view_id` and `stamp_ns` are taken over. `now` gives seconds, for the report alone.
// Deterministic but for those.
// Throws Error(vision_no_depth) where an eye is blank or too little of the box's silhouette has depth.
object_model::Perception perceive(const RectifiedPair& pair, const object_model::ObjectBox& box,
                                  const Surroundings& surroundings, const PerceiveSettings& settings,
                                  const std::function<double()>& now, PerceiveReport& report);

}  // namespace periplus::vision
