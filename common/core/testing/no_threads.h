// A process in which no thread starts, as where the system has none left: stacks are asked for that no memory holds.
#pragma once

#include <pthread.h>

#include <cstddef>

#include "common/core/error.h"

namespace periplus {

// While it lives. Threads that run already go on.
class NoThreads {
 public:
  NoThreads() {
    pthread_attr_t none;
    require(::pthread_getattr_default_np(&before_) == 0 && ::pthread_getattr_default_np(&none) == 0, ErrorCode::internal, "default thread attributes");
    require(::pthread_attr_setstacksize(&none, std::size_t{1} << 60) == 0 && ::pthread_setattr_default_np(&none) == 0, ErrorCode::internal, "stack size");
    ::pthread_attr_destroy(&none);
  }
  ~NoThreads() {
    ::pthread_setattr_default_np(&before_);
    ::pthread_attr_destroy(&before_);
  }
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;

 private:
  pthread_attr_t before_;
};

}  // namespace periplus
