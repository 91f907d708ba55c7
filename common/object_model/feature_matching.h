// Which features of two views show the same spot of the object: thesis 4.2.2.2, Algorithm 6.
#pragma once

#include <span>
#include <vector>

#include "common/object_model/perception.h"

namespace periplus::object_model {

struct MatchingSettings {
  double most_distance = 0.7;      // descriptors further apart are no match: Euclidean, of root_sift and surf (0..2) ...
  double most_bits = 0.3;          // ... and share of differing bits, of akaze and orb (0..1)
  double ratio = 0.8;              // the best match must be nearer than this share of the second best
  double distance_m = 0.01;        // two features are as far apart in one view as in the other, to this [m] ...
  double distance_share = 0.05;    // ... and this share of their distance
  double coherent_share = 0.5;     // of the other matches must agree with a match ...
  int least_coherent = 3;          // ... and at least so many; 0 with a share of 0 switches the comparison of distances off
  int most = 0;                    // matches kept, the nearest first; 0: all
  void check() const;              // throws Error(bad_input)
  bool operator==(const MatchingSettings&) const = default;
};

struct FeatureMatch {
  int a = 0, b = 0;                // indices of the features
  double distance = 0;             // of their descriptors (descriptor.h)
  bool operator==(const FeatureMatch&) const = default;
};

// Each feature's nearest in the other view by descriptor, where that is mutual, near enough and clearly nearer than the second;
// of these, those whose distances in space to the other matches are the same in both views: while there are matches with too
// few that agree with them, the ones with the fewest are dropped, the furthest apart first. Distances within a view do not
// depend on its pose. Only descriptors of one kind and its length are compared.
//
// In ascending order of distance, then a, then b. match_views(b, a) finds the same pairs (but for the last of equal ones where
// `most` cuts). Deterministic.
std::vector<FeatureMatch> match_views(std::span<const Feature> a, std::span<const Feature> b, const MatchingSettings& settings = {});

}  // namespace periplus::object_model
