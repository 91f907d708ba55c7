#include "services/simulator/camera_sensor.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/core/hash.h"
#include "common/core/random.h"

namespace periplus::simulator {

void expose(ImageU8& image, const CameraSensor& sensor, std::uint64_t seed) {
  Random random(seed);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double noise = sensor.noise > 0 ? sensor.noise * random.normal() : 0;
      for (int c = 0; c < image.channels; ++c) {
        const double light = sensor.blank ? 128 : sensor.gain * image.at(x, y, c) + sensor.offset;
        image.at(x, y, c) = static_cast<std::uint8_t>(std::clamp(std::round(light + noise), 0.0, 255.0));
      }
    }
}

std::uint64_t picture_seed(std::uint64_t seed, std::string_view view_id, std::string_view camera) {
  // A view is named <run>-<view>; the noise must not tell one run from another.
  const std::string_view view = view_id.substr(view_id.rfind('-') + 1);
  const std::string text = std::to_string(seed) + "/" + std::string(view) + "/" + std::string(camera);
  return std::stoull(sha256_hex(text).substr(0, 16), nullptr, 16);
}

}  // namespace periplus::simulator
