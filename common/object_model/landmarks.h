// Landmarks: spots on the object that one or more views show as features (thesis 4.2.2.2, 5.1.2).
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/object_model/feature_matching.h"
#include "common/object_model/perception.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::object_model {

struct View;  // object_model.h

// A feature: of views[view]->features[feature].
struct Observation {
  std::size_t view = 0, feature = 0;
  auto operator<=>(const Observation&) const = default;
};

struct SeenLandmark {
  Landmark place;                      // mean of its observations: weights 1 / z^4, as the variance of stereo's depth grows
  std::vector<Observation> seen;       // ascending; their features hold the descriptors
};

struct LandmarkSettings {
  MatchingSettings matching;
  double reach_m = 0.015;              // observations of one landmark are no further apart, by the views' poses
  double most_turn = 1.3;              // views whose optical axes differ by more are not compared [rad]: no descriptor spans it
  void check() const;                  // throws Error(bad_input)
};

// What match_views found of pairs of views, kept from one call of merge_landmarks to the next. It holds for a copy of a view, too, as growth
// and revisions make them, if that goes by the same name and has the same features to the last bit. It holds the pairs of the last call alone.
struct KeptMatches {
  MatchingSettings settings;           // they were found with
  std::map<std::pair<std::shared_ptr<const View>, std::shared_ptr<const View>>, std::vector<FeatureMatch>> of;
};

// Every feature of the views belongs to exactly one landmark. Two features are observations of one if their views match them
// (Algorithm 6) and their places agree; the nearest by descriptor are joined first, and two groups only if no view saw both. SIFT's
// several directions at one spot of a view are one observation's. In the order of their first observation. Deterministic; the
// same to the last bit with `kept` matches and without.
std::vector<SeenLandmark> merge_landmarks(std::span<const std::shared_ptr<const View>> views, const LandmarkSettings& settings = {},
                                          KeptMatches* kept = nullptr);

// The voxel that a landmark belongs to (5.1.2): its own if that is known or unknown, else the nearest such one whose centre is
// within half the landmark's size and half a voxel's diagonal, and no more than 8 voxels. Nothing if there is none: the object is not there.
std::optional<Eigen::Vector3i> landmark_voxel(const Landmark& landmark, const voxel::OccupancyGrid& grid);

}  // namespace periplus::object_model
