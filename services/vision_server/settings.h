// Parameters of the vision server, from its YAML file; config/default.yaml says what each means.
#pragma once

#include <chrono>
#include <cstdint>

#include "common/core/config.h"
#include "services/vision_server/perceive.h"

namespace periplus::vision {

struct VisionSettings {
  int attempts = 3;                                    // to get a complete set of images
  std::chrono::milliseconds trigger_deadline{5000};
  std::chrono::milliseconds images_deadline{2000};
  std::int64_t stamp_tolerance_ns = 0;
  int views_kept = 32;
  int threads = 2;                                     // of OpenCV
  PerceiveSettings perceive;
};

// Throws Error(bad_input) for unknown keys and values out of range.
VisionSettings read_settings(const config::Node& root);

}  // namespace periplus::vision
