// Wall and steady time as the services tell it: [s], [ns] since 1970.
#pragma once

#include <chrono>
#include <cstdint>

namespace periplus {

// [s] since `start`.
inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// A setting in seconds as the waits take it.
inline std::chrono::milliseconds milliseconds(double seconds) { return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000)); }

// UNIX time [ns].
inline std::int64_t wall_time_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace periplus
