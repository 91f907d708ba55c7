// Points of an image that are found again from elsewhere, with descriptors: SIFT (Lowe 2004) as RootSIFT (Arandjelovic and
// Zisserman 2012), AKAZE (Alcantarilla 2013), ORB (Rublee 2011), and SURF (Bay 2008; thesis 4.2.2) where OpenCV has it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/geometry/image.h"
#include "common/object_model/descriptor.h"

namespace periplus::vision {

using object_model::DescriptorKind;

struct DetectorSettings {
  DescriptorKind kind = DescriptorKind::root_sift;
  double contrast = 0.02;      // SIFT's contrast threshold
  double edge = 12;            // SIFT's edge threshold
  double akaze_response = 0.001;
  double orb_fast = 12;        // grey levels between a corner and the ring around it
  double surf_hessian = 200;
  void check() const;          // throws Error(bad_input); for a kind that cannot be had with the reason
};

struct Keypoint {
  float u = 0, v = 0;          // [px]
  float size = 0;              // diameter [px]
  float angle = 0;             // [rad]
  float response = 0;          // how distinct; comparable within one kind
};

struct DetectedFeatures {
  DescriptorKind kind = DescriptorKind::root_sift;
  std::vector<Keypoint> points;             // by v, u, size, angle
  std::vector<std::uint8_t> descriptors;    // descriptor_octets(kind) each
  std::span<const std::uint8_t> descriptor(std::size_t i) const {
    const std::size_t n = object_model::descriptor_octets(kind);
    return {descriptors.data() + i * n, n};
  }
};

// Of the grey image where `mask` (same size) is not 0. `sensitivity` divides the threshold of response: 2 finds fainter ones too.
// Deterministic, whatever cv::setNumThreads says. Throws Error(bad_size | bad_input).
DetectedFeatures detect_features(const ImageU8& grey, const ImageU8& mask, const DetectorSettings& settings, double sensitivity = 1);

// Why features of this kind cannot be had here; empty if they can.
std::string unavailable(DescriptorKind kind);

}  // namespace periplus::vision
