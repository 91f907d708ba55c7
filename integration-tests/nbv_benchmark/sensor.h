// What a look delivers: depth maps of the object, ideal or by stereo from rendered images.
//
//   ideal, one camera   true depth at every pixel
//   ideal, pair         both eyes' true depth where the other eye sees the point too
//   stereo, pair        rendered pictures with noise and unequal gain, matched by the vision server's own code
#pragma once

#include <memory>
#include <vector>

#include "common/object_model/perception.h"
#include "integration-tests/nbv_benchmark/arena.h"

namespace periplus::nbv_benchmark {

enum class SensorKind { ideal, stereo };
const char* to_string(SensorKind kind);

struct Look {
  std::vector<object_model::DepthMap> depth;   // one camera: one; pair: left, right
  double silhouette_valid_share = 1;           // of the object's silhouette with a depth
};

class Sensor {
 public:
  virtual ~Sensor() = default;
  // From X_WC (left eye). The same bytes for the same pose and number.
  virtual Look look(const Pose& X_WC, int number) = 0;
};

// The arena must outlive the sensor. Stereo throws Error(bad_input) for an arena of one camera, Error(sim_render_failed) where
// nothing can be drawn.
std::unique_ptr<Sensor> make_sensor(SensorKind kind, const Arena& arena, const Subject& subject, std::uint64_t seed);

// The room's walls, where nothing nearer is [m].
inline constexpr float kBackground = 6;

}  // namespace periplus::nbv_benchmark
