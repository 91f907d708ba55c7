// Waiting in tests for what another thread or process will do.
#pragma once

#include <chrono>
#include <thread>

namespace periplus::dds::testing {

// True as soon as `condition` holds; false if it still does not after `limit`.
template <class Condition>
bool eventually(Condition condition, std::chrono::milliseconds limit = std::chrono::seconds(10)) {
  for (const auto end = std::chrono::steady_clock::now() + limit; std::chrono::steady_clock::now() < end;
       std::this_thread::sleep_for(std::chrono::milliseconds(5))) {
    if (condition()) return true;
  }
  return condition();
}

}  // namespace periplus::dds::testing
