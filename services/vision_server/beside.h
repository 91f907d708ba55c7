// Work on a thread of its own, as the two eyes' is done side by side.
#pragma once

#include <future>
#include <opencv2/core/utility.hpp>
#include <utility>

namespace periplus::vision {

// On another thread where OpenCV may use several and one starts; else when the result is asked for. What it throws, the result throws.
template <class Work>
auto beside(Work&& work) {
  return std::async(cv::getNumThreads() > 1 ? std::launch::async | std::launch::deferred : std::launch::deferred, std::forward<Work>(work));
}

}  // namespace periplus::vision
