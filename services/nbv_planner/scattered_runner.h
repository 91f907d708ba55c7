// A search whose tasks are shared with other instances of the planner: same bytes as alone, whatever becomes of them.
//
// Who leads runs the search with a ScatteredRunner: its own threads take a stage's tasks from the front, each other instance
// a few at a time from the back. What an instance that is lost, late or wrong had taken is done again here. An instance is
// asked with the results of all stages before, as numbers: it runs the same search on them up to that stage (run_part), so
// it keeps nothing between two questions and may come and go.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "services/nbv_planner/task_runner.h"

namespace periplus::nbv {

// Results of some of a stage's tasks, one after the other.
struct StageNumbers {
  std::vector<std::uint32_t> sizes;  // of each result
  Numbers numbers;

  // Throws Error(bad_size) unless the sizes add up and there are `count` results.
  void check(std::size_t count) const;
};
using StageHistory = std::vector<std::shared_ptr<const StageNumbers>>;  // one for each stage that is over

// The part of a search that is another's: results of tasks first .. last-1 of the stage that follows `done`. `search` runs
// the whole search with the runner that it is given; it is left by an exception of ours when the stage is reached.
// Throws Error(bad_input | bad_size) if the search has no such stage or tasks, or `done` are not its results.
StageNumbers run_part(const std::function<void(TaskRunner&)>& search, const StageHistory& done, int first, int last, int threads);

// Another instance, as the one that leads sees it. Used by one thread.
class OtherInstance {
 public:
  virtual ~OtherInstance() = default;
  // As run_part, there; nothing if it is lost or refuses: it is not asked again. `given_up` becomes true when the answer is
  // no longer wanted.
  virtual std::optional<StageNumbers> run(const StageHistory& done, int first, int last,
                                          const std::function<bool()>& given_up) = 0;
};

class ScatteredRunner : public ThreadRunner {
 public:
  ScatteredRunner(int threads, std::vector<std::unique_ptr<OtherInstance>> others,
                  std::optional<Clock::time_point> deadline = std::nullopt);
  ~ScatteredRunner() override;
  ScatteredRunner(const ScatteredRunner&) = delete;
  ScatteredRunner& operator=(const ScatteredRunner&) = delete;

  // Tasks whose results were used, and how many of them others made.
  int tasks() const;
  int tasks_elsewhere() const;

 protected:
  void run(const Stage& stage) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::nbv
