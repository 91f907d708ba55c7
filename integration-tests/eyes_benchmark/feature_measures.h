// How well features are placed, matched between views and joined to landmarks, against the true surface.
#pragma once

#include <span>
#include <vector>

#include "common/mesh/triangle_tree.h"
#include "common/object_model/feature_matching.h"
#include "common/object_model/landmarks.h"
#include "integration-tests/eyes_benchmark/stereo_measures.h"

namespace periplus::eyes_benchmark {

inline constexpr double kSameSpot = 0.005;  // features whose true places are no further apart show the same spot [m]

// Where the rays of the features meet the mesh, by (u, v); not finite where they miss it.
std::vector<Eigen::Vector3d> true_places(std::span<const object_model::Feature> features, const Pinhole& camera, const Pose& X_WC, const mesh::TriangleTree& tree);

// Of two views.
struct MatchQuality {
  double degrees = 0;         // how far the second is turned about the object
  std::size_t matches = 0, right = 0;
  std::size_t possible = 0;   // features of the first view of which the second has one of the same spot and of like size (1.5)
  double precision() const { return matches == 0 ? 0 : static_cast<double>(right) / static_cast<double>(matches); }
  double recall() const { return possible == 0 ? 0 : static_cast<double>(right) / static_cast<double>(possible); }
};
// Features `a` and `b` with their true places. Throws Error(bad_size) unless there is a place for each.
MatchQuality match_quality(std::span<const object_model::Feature> a, std::span<const Eigen::Vector3d> true_a, std::span<const object_model::Feature> b,
                           std::span<const Eigen::Vector3d> true_b, std::span<const object_model::FeatureMatch> matches);

struct LandmarkQuality {
  std::size_t landmarks = 0;
  std::size_t joined = 0;     // seen from two views or more
  std::size_t pure = 0;       // of these, whose observations all show the spot of the first
  std::size_t observations = 0;  // of the joined ones
  double purity() const { return joined == 0 ? 0 : static_cast<double>(pure) / static_cast<double>(joined); }
};
// `truth[view][feature]`.
LandmarkQuality landmark_quality(std::span<const object_model::SeenLandmark> landmarks, const std::vector<std::vector<Eigen::Vector3d>>& truth);

}  // namespace periplus::eyes_benchmark
