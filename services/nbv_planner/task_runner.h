// Where the tasks of a search run. A search is a sequence of stages; a stage is a number of tasks that do not depend on
// each other, and what is made of their results in the order of their numbers. A task depends on its number, on the
// situation and the settings, and on the results of earlier stages, and on nothing else. So threads, other processes and
// other hosts may share a stage, one may do another's part again, and the answer has the same bytes.
//
//   const auto samples = runner.map<Sample>(count, [&](int i, int worker) { return look_around(i, workspaces[worker]); });
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "services/nbv_planner/task_numbers.h"

namespace periplus::nbv {

class TaskRunner {
 public:
  virtual ~TaskRunner() = default;

  // How many tasks may run at once in this process: `worker` of a task is 0 .. workers()-1, each by one thread at a time.
  virtual int workers() const = 0;
  // True once the wall-clock limit has passed, if there is one.
  virtual bool out_of_time() const { return false; }

  // The results of tasks 0 .. count-1. Of those that did not begin before time was out (but for the first `at_least`)
  // there is none: with them missing a search returns the best of what it has. Without a limit all are there.
  // `task(i, worker)` returns a Result, a type that task_numbers.h can write; what it throws comes out here.
  template <class Result, class Task>
  std::vector<std::optional<Result>> map(int count, const Task& task, int at_least = 0) {
    std::vector<std::optional<Result>> results(count);
    Stage stage;
    stage.count = count;
    stage.at_least = at_least;
    stage.compute = [&](int i, int worker) { results[i] = task(i, worker); };
    stage.write = [&](int i, Numbers& to) { append_numbers(*results[i], to); };
    stage.read = [&](int i, std::span<const double> from) { results[i] = from_numbers<Result>(from); };
    run(stage);
    return results;
  }

 protected:
  // Each task is computed or read, once or several times, by one thread at a time; different tasks concurrently.
  struct Stage {
    int count = 0, at_least = 0;
    std::function<void(int i, int worker)> compute;
    std::function<void(int i, Numbers& to)> write;                // of a task that was computed or read
    std::function<void(int i, std::span<const double> from)> read;
  };
  virtual void run(const Stage& stage) = 0;
};

// The threads of this process.
class ThreadRunner : public TaskRunner {
 public:
  using Clock = std::chrono::steady_clock;

  // `threads` is clamped to 1 .. 64; the caller's own is one of them.
  explicit ThreadRunner(int threads, std::optional<Clock::time_point> deadline = std::nullopt);
  int workers() const override { return workers_; }
  bool out_of_time() const override { return deadline_ && Clock::now() >= *deadline_; }

 protected:
  void run(const Stage& stage) override;

 private:
  int workers_;
  std::optional<Clock::time_point> deadline_;
};

// Calls `work(worker)` on `workers` threads, the caller's among them; the first exception by number of worker comes out.
void on_threads(int workers, const std::function<void(int worker)>& work);

}  // namespace periplus::nbv
