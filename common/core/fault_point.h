// Named places in the program at which a test may end it or look at what stands on the disk. Without a hook: one load.
#pragma once

#include <atomic>

namespace periplus {

using FaultHook = void (*)(const char* point);

inline std::atomic<FaultHook>& fault_hook() {
  static std::atomic<FaultHook> hook{nullptr};
  return hook;
}

inline void fault_point(const char* point) {
  if (const FaultHook hook = fault_hook().load(std::memory_order_relaxed)) hook(point);
}

}  // namespace periplus
