// Writes files while the state machine goes on: jobs run one after the other, in order, on a thread of its own.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace periplus::supervisor {

class WriteQueue {
 public:
  WriteQueue();
  ~WriteQueue();  // does what is left

  // Waits while kMost jobs are in the queue. What an earlier job threw is thrown here, once; the job is then not taken.
  void add(std::function<void()> job);
  // Returns when all is done; throws like add().
  void flush();

 private:
  static constexpr std::size_t kMost = 64;
  void work();
  void rethrow();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;  // the first is under way
  std::exception_ptr failure_;
  bool stopping_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace periplus::supervisor
