// What a camera's sensor makes of the light: gain, offset and noise.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/geometry/image.h"

namespace periplus::simulator {

struct CameraSensor {
  double gain = 1, offset = 0;  // grey levels of 0..255
  double noise = 0;             // standard deviation [grey levels]; equal in all channels of a pixel
  bool blank = false;           // a fault: plain grey
};

// gain * value + offset + noise, rounded and held within 0..255. The same bytes for the same seed.
void expose(ImageU8& image, const CameraSensor& sensor, std::uint64_t seed);

// Seed of one picture: of the simulator's seed, the view and the camera, so that a view shown again is the same picture, and
// so is the view of that name (what follows the last '-' of its id) in another run.
std::uint64_t picture_seed(std::uint64_t seed, std::string_view view_id, std::string_view camera);

}  // namespace periplus::simulator
