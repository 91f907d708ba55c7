// Which features of the left eye to keep, by what the right eye shows: thesis 4.2.2.1, Algorithms 4 and 5.
#pragma once

#include <cstddef>
#include <vector>

#include "services/vision_server/feature_detector.h"

namespace periplus::vision {

enum class FeatureSelection {
  left_alone,        // the tests of the left image alone
  geometry_first,    // Algorithm 4: candidates on the epipolar line, at the disparity, of like scale; of these the nearest by descriptor, if it is clear
  descriptor_first,  // Algorithm 5: the nearest by descriptor of all; kept if it is on the line, at the disparity and of like scale
};

struct SelectionSettings {
  FeatureSelection method = FeatureSelection::descriptor_first;
  double size_min_px = 2, size_max_px = 60;  // s_min, s_max
  double response_min = 0;                   // the least response; the detector has a threshold of its own
  double stereo_px = 1.5;                    // off the epipolar line, and off the disparity
  double scale_ratio = 1.5;                  // of sizes, either way
  double most_distance = 0.7;                // of descriptors: Euclidean (0..2), geometry_first
  double most_bits = 0.35;                   // and share of bits (0..1)
  double second_ratio = 0.5;                 // nearest by second nearest candidate, geometry_first
  void check() const;                        // throws Error(bad_input)
};

struct SelectedFeature {
  std::size_t left = 0, right = 0;           // indices; right 0 for left_alone
  double disparity = 0;                      // between the two features [px]; the map's for left_alone
  double distance = 0;                       // of their descriptors (common/object_model/descriptor.h)
};

// `disparity[i]` [px] is that of left feature i by the disparity map, 0 where it is not on the object. In the order of the left features.
// Throws Error(bad_size) unless there is one for each; Error(bad_input) for features of two kinds.
std::vector<SelectedFeature> select_features(const DetectedFeatures& left, const DetectedFeatures& right, const std::vector<double>& disparity,
                                             const SelectionSettings& settings);

}  // namespace periplus::vision
