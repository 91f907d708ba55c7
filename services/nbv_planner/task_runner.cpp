#include "services/nbv_planner/task_runner.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>

namespace periplus::nbv {

void on_threads(int workers, const std::function<void(int worker)>& work) {
  std::vector<std::exception_ptr> errors(std::max(workers, 1));
  const auto guarded = [&](int worker) {
    try {
      work(worker);
    } catch (...) {
      errors[worker] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (int worker = 1; worker < workers; ++worker) others.emplace_back(guarded, worker);
    guarded(0);
  }
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

ThreadRunner::ThreadRunner(int threads, std::optional<Clock::time_point> deadline)
    : workers_(std::clamp(threads, 1, 64)), deadline_(deadline) {}

void ThreadRunner::run(const Stage& stage) {
  std::atomic<int> next{0};
  on_threads(std::min(workers_, stage.count), [&](int worker) {
    for (int i; (i = next++) < stage.count;) {
      if (i >= stage.at_least && out_of_time()) return;
      stage.compute(i, worker);
    }
  });
}

}  // namespace periplus::nbv
