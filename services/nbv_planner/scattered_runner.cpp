#include "services/nbv_planner/scattered_runner.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <string>
#include <thread>

#include "common/core/log.h"

namespace periplus::nbv {
namespace {

using Clock = std::chrono::steady_clock;

// What others have taken is late when it takes longer than our own tasks would, times this, and a little.
constexpr double kPatience = 2.0;
constexpr auto kRoundTrip = std::chrono::milliseconds(5);

// Leaves the search when the part that was asked for is done.
struct PartDone {};

class PartRunner : public TaskRunner {
 public:
  PartRunner(const StageHistory& done, int first, int last, int threads)
      : done_(done), first_(first), last_(last), workers_(std::clamp(threads, 1, 64)) {}
  int workers() const override { return workers_; }
  StageNumbers take() { return std::move(part_); }

 protected:
  void run(const Stage& stage) override {
    if (at_ < done_.size()) {
      const StageNumbers& results = *done_[at_++];
      results.check(static_cast<std::size_t>(stage.count));
      std::size_t from = 0;
      for (int i = 0; i < stage.count; from += results.sizes[i++]) {
        stage.read(i, {results.numbers.data() + from, results.sizes[i]});
      }
      return;
    }
    require(first_ >= 0 && first_ < last_ && last_ <= stage.count, ErrorCode::bad_input,
            "the stage has " + std::to_string(stage.count) + " tasks; asked for " + std::to_string(first_) + " to " +
                std::to_string(last_));
    std::atomic<int> next{first_};
    on_threads(std::min(workers_, last_ - first_), [&](int worker) {
      for (int i; (i = next++) < last_;) stage.compute(i, worker);
    });
    for (int i = first_; i < last_; ++i) {
      const std::size_t before = part_.numbers.size();
      stage.write(i, part_.numbers);
      part_.sizes.push_back(static_cast<std::uint32_t>(part_.numbers.size() - before));
    }
    throw PartDone();
  }

 private:
  const StageHistory& done_;
  const int first_, last_, workers_;
  std::size_t at_ = 0;
  StageNumbers part_;
};

}  // namespace

void StageNumbers::check(std::size_t count) const {
  const std::size_t sum = std::accumulate(sizes.begin(), sizes.end(), std::size_t{0});
  require(sizes.size() == count && sum == numbers.size(), ErrorCode::bad_size,
          "results of " + std::to_string(sizes.size()) + " tasks with " + std::to_string(numbers.size()) +
              " numbers where " + std::to_string(count) + " tasks and " + std::to_string(sum) + " numbers belong");
}

StageNumbers run_part(const std::function<void(TaskRunner&)>& search, const StageHistory& done, int first, int last,
                      int threads) {
  PartRunner runner(done, first, last, threads);
  try {
    search(runner);
  } catch (const PartDone&) {
    return runner.take();
  }
  throw_error(ErrorCode::bad_input, "the search has no stage after " + std::to_string(done.size()) + " of them");
}

// A task is open, done, in the hands of one of our workers, or away: taken by another instance. What is away and late one of
// our workers takes as well; the answer that comes first counts, and both are the same.
struct ScatteredRunner::Impl {
  enum class State { open, ours, away, done };
  struct Task {
    State state = State::open;
    Clock::time_point due{};  // of what is away
  };

  std::mutex mutex;
  std::condition_variable changed;
  bool ended = false;
  const Stage* stage = nullptr;  // the one under way
  int number = 0;                // of that stage
  std::vector<Task> tasks;
  int beginning = 0;             // our workers that have not taken their first task of the stage
  int others_at_work = 0;
  double task_seconds = 0;       // of our own tasks, the newest counting most
  StageHistory history;
  int used = 0, elsewhere = 0;
  std::vector<std::jthread> askers;  // last: their threads use the above

  // Open tasks beyond those that our own workers are about to begin.
  int to_give() const {
    const auto open = std::count_if(tasks.begin(), tasks.end(), [](const Task& t) { return t.state == State::open; });
    return static_cast<int>(open) - beginning;
  }
  // Of those before `end`; -1 if there is none.
  int first_open(int end) const {
    for (int i = 0; i < end; ++i) {
      if (tasks[i].state == State::open) return i;
    }
    return -1;
  }

  // The next task for a worker of ours, waiting for what is away and not late; -1 when there is nothing left to do.
  int next(std::unique_lock<std::mutex>& lock, const ScatteredRunner& runner) {
    for (;;) {
      const bool hurry = runner.out_of_time();
      const int end = hurry ? std::min<int>(stage->at_least, static_cast<int>(tasks.size())) : static_cast<int>(tasks.size());
      if (const int open = first_open(end); open >= 0) return open;
      const auto now = Clock::now();
      std::optional<Clock::time_point> earliest;
      for (int i = end - 1; i >= 0; --i) {  // others work from the front of their part
        if (tasks[i].state != State::away) continue;
        if (hurry || tasks[i].due <= now) return i;
        if (!earliest || tasks[i].due < *earliest) earliest = tasks[i].due;
      }
      if (!earliest) return -1;
      changed.wait_until(lock, *earliest);
    }
  }

  void work(int worker, const ScatteredRunner& runner) {
    std::unique_lock lock(mutex);
    for (int i, taken = 0; (i = next(lock, runner)) >= 0; ++taken) {
      tasks[i].state = State::ours;
      if (taken == 0) --beginning;
      lock.unlock();
      const auto begin = Clock::now();
      stage->compute(i, worker);
      const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
      lock.lock();
      task_seconds = task_seconds > 0 ? 0.7 * task_seconds + 0.3 * seconds : seconds;
      tasks[i].state = State::done;
      changed.notify_all();
    }
  }

  // A thread for each other instance.
  void ask(OtherInstance& other, const ScatteredRunner& runner) {
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [&] { return ended || (stage != nullptr && !runner.out_of_time() && to_give() > 0); });
      if (ended) break;
      // The open tasks at the end, half of this instance's share of them at once.
      int last = static_cast<int>(tasks.size());
      while (tasks[last - 1].state != State::open) --last;
      const int share = std::max(1, to_give() / (2 * (others_at_work + 1)));
      int first = last;
      while (first > 0 && last - first < share && tasks[first - 1].state == State::open) --first;
      const auto due = Clock::now() + kRoundTrip +
                       std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kPatience * task_seconds * (last - first)));
      for (int i = first; i < last; ++i) tasks[i] = {State::away, due};
      const int asked = number;
      const StageHistory done = history;
      lock.unlock();
      std::optional<StageNumbers> results;
      try {
        results = other.run(done, first, last, [&] {
          const std::lock_guard guard(mutex);
          return ended;
        });
        if (results) results->check(static_cast<std::size_t>(last - first));
      } catch (const std::exception& e) {
        log::warn("another planner's results cannot be used", {{"cause", e.what()}});
        results.reset();
      }
      lock.lock();
      const bool here = stage != nullptr && number == asked;
      if (here && results && !take(*results, first)) results.reset();
      if (!results) {
        for (int i = first; here && i < last; ++i) {
          if (tasks[i].state == State::away) tasks[i].state = State::open;
        }
        break;
      }
      changed.notify_all();
    }
    --others_at_work;
    changed.notify_all();
  }

  // False if they are not results of this search.
  bool take(const StageNumbers& results, int first) {
    std::size_t from = 0;
    for (std::size_t k = 0; k < results.sizes.size(); from += results.sizes[k++]) {
      Task& task = tasks[first + static_cast<int>(k)];
      if (task.state != State::away) continue;
      try {
        stage->read(first + static_cast<int>(k), {results.numbers.data() + from, results.sizes[k]});
      } catch (const Error& e) {
        log::warn("another planner's results cannot be used", {{"cause", e.what()}});
        return false;
      }
      task.state = State::done;
      ++elsewhere;
    }
    return true;
  }
};

ScatteredRunner::ScatteredRunner(int threads, std::vector<std::unique_ptr<OtherInstance>> others,
                                 std::optional<Clock::time_point> deadline)
    : ThreadRunner(threads, deadline), impl_(std::make_unique<Impl>()) {
  impl_->others_at_work = static_cast<int>(others.size());
  for (auto& other : others) {
    impl_->askers.emplace_back([this, instance = std::move(other)] { impl_->ask(*instance, *this); });
  }
}

ScatteredRunner::~ScatteredRunner() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->ended = true;
  }
  impl_->changed.notify_all();
  impl_->askers.clear();
}

int ScatteredRunner::tasks() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->used;
}

int ScatteredRunner::tasks_elsewhere() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->elsewhere;
}

void ScatteredRunner::run(const Stage& stage) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->stage = &stage;
    impl_->tasks.assign(static_cast<std::size_t>(stage.count), {});
    impl_->beginning = std::min(workers(), stage.count);
  }
  impl_->changed.notify_all();
  // However this ends, nobody uses the stage any more.
  struct End {
    Impl& impl;
    ~End() {
      const std::lock_guard lock(impl.mutex);
      impl.stage = nullptr;
      ++impl.number;
    }
  } end{*impl_};
  on_threads(std::min(workers(), stage.count), [&](int worker) { impl_->work(worker, *this); });
  const std::lock_guard lock(impl_->mutex);
  StageNumbers results;
  for (int i = 0; i < stage.count; ++i) {
    if (impl_->tasks[i].state != Impl::State::done) continue;  // time was out
    ++impl_->used;
    const std::size_t before = results.numbers.size();
    stage.write(i, results.numbers);
    results.sizes.push_back(static_cast<std::uint32_t>(results.numbers.size() - before));
  }
  impl_->history.push_back(std::make_shared<const StageNumbers>(std::move(results)));
}

}  // namespace periplus::nbv
