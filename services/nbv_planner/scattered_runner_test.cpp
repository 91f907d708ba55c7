#include "services/nbv_planner/scattered_runner.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "common/core/random.h"
#include "services/nbv_planner/testing/situations.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv {
namespace {

using namespace std::chrono_literals;
using Search = std::function<void(TaskRunner&)>;

// What an instance does when it is asked for the n-th time.
enum class Fate { answers, dies, hangs, answers_rubbish, answers_too_little, comes_late };

class Other : public OtherInstance {
 public:
  Other(Search search, std::function<Fate(int)> fate, std::atomic<int>* asked)
      : search_(std::move(search)), fate_(std::move(fate)), asked_(asked) {}
  std::optional<StageNumbers> run(const StageHistory& done, int first, int last,
                                  const std::function<bool()>& given_up) override {
    const Fate fate = fate_((*asked_)++);
    if (fate == Fate::dies) return std::nullopt;
    StageNumbers results = run_part(search_, done, first, last, 1);
    if (fate == Fate::comes_late) std::this_thread::sleep_for(60ms);
    if (fate == Fate::answers_rubbish) {
      for (double& number : results.numbers) number = 0.5;
    }
    if (fate == Fate::answers_too_little) results.numbers.pop_back();
    if (fate == Fate::hangs) {
      while (!given_up()) std::this_thread::sleep_for(1ms);
      return std::nullopt;
    }
    return results;
  }

 private:
  Search search_;
  std::function<Fate(int)> fate_;
  std::atomic<int>* asked_;
};

Situation mixed_block() {
  return testing::around_the_origin(20, [](int x, int y, int z) {
    return (x * y + z) % 7 == 0      ? voxel::VoxelState::empty
           : (x + y * z) % 3 == 0 ? voxel::VoxelState::unknown
                                  : voxel::VoxelState::known;
  });
}

SearchSettings small_search() {
  SearchSettings s;
  s.method = SearchMethod::fast;
  s.fast.positions = 40;
  s.fast.starts = 4;
  s.max_evaluations = 300;
  return s;
}

bool same_view(const PlannedView& a, const PlannedView& b) {
  return std::memcmp(a.X_WC.matrix().data(), b.X_WC.matrix().data(), 16 * sizeof(double)) == 0 && a.f_e == b.f_e &&
         a.gain_scale == b.gain_scale && a.evaluations == b.evaluations &&
         a.evaluation.gain.voxels == b.evaluation.gain.voxels && a.evaluation.gain.pixels == b.evaluation.gain.pixels;
}

TEST(ScatteredRunner, SameBytesWhateverBecomesOfTheOthers) {
  const Situation s = mixed_block();
  const Evaluator evaluator(s, {}, {});
  const Search search = [&](TaskRunner& r) { plan_view(evaluator, 6, small_search(), r); };
  ThreadRunner alone(1);
  const PlannedView expected = plan_view(evaluator, 6, small_search(), alone);

  struct Case {
    const char* name;
    std::vector<std::function<Fate(int)>> fates;
    bool helps;
  };
  const auto always = [](Fate f) { return [f](int) { return f; }; };
  const auto then = [](int n, Fate f) { return [n, f](int asked) { return asked < n ? Fate::answers : f; }; };
  const std::vector<Case> cases{
      {"nobody", {}, false},
      {"one", {always(Fate::answers)}, true},
      {"three", {always(Fate::answers), always(Fate::answers), always(Fate::answers)}, true},
      {"dies at once", {always(Fate::dies)}, false},
      {"dies on the way, the other goes on", {then(3, Fate::dies), always(Fate::answers)}, true},
      {"hangs on the way", {then(2, Fate::hangs)}, true},
      {"rubbish", {always(Fate::answers_rubbish)}, false},
      {"too little", {then(1, Fate::answers_too_little)}, true},
      {"always late", {always(Fate::comes_late)}, false},
  };
  for (const Case& c : cases) {
    for (const int threads : {1, 2}) {
      // On a busy machine all may be done here before another's thread has begun: the bytes are the same each time, help must
      // come some time.
      bool was_asked = false, helped = false;
      for (int attempt = 0; attempt < 10 && !(was_asked == !c.fates.empty() && (helped || !c.helps)); ++attempt) {
        std::atomic<int> asked{0};
        std::vector<std::unique_ptr<OtherInstance>> others;
        for (const auto& fate : c.fates) others.push_back(std::make_unique<Other>(search, fate, &asked));
        ScatteredRunner runner(threads, std::move(others));
        const PlannedView v = plan_view(evaluator, 6, small_search(), runner);
        EXPECT_TRUE(same_view(expected, v)) << c.name << ", threads: " << threads;
        EXPECT_LE(runner.tasks_elsewhere(), runner.tasks());
        EXPECT_GT(runner.tasks(), 55) << c.name;
        was_asked = asked > 0;
        helped = runner.tasks_elsewhere() > 0;
      }
      EXPECT_EQ(was_asked, !c.fates.empty()) << c.name;
      EXPECT_TRUE(helped || !c.helps) << c.name;
    }
  }
}

// Stages of plain numbers, each depending on those before.
std::vector<std::uint64_t> chain(TaskRunner& runner, const std::vector<int>& counts, const std::function<void(int, int)>& at = {}) {
  std::uint64_t state = 1;
  std::vector<std::uint64_t> states;
  for (std::size_t stage = 0; stage < counts.size(); ++stage) {
    const auto results = runner.map<std::uint64_t>(counts[stage], [&](int i, int) {
      if (at) at(static_cast<int>(stage), i);
      return Random(state + static_cast<std::uint64_t>(i)).next();
    });
    for (const auto& r : results) state = state * 31 + r.value();
    states.push_back(state);
  }
  return states;
}

TEST(ScatteredRunner, OthersTakeFromTheBackWhileWeTakeFromTheFront) {
  const std::vector<int> counts{40};
  ThreadRunner alone(1);
  const auto expected = chain(alone, counts);
  std::atomic<int> asked{0};
  std::vector<std::unique_ptr<OtherInstance>> others;
  others.push_back(std::make_unique<Other>([&](TaskRunner& r) { chain(r, counts); }, [](int) { return Fate::answers; }, &asked));
  ScatteredRunner runner(1, std::move(others));
  std::vector<int> ours;
  const auto at = [&](int, int i) {
    ours.push_back(i);
    if (i > 0) return;
    const auto give_up = std::chrono::steady_clock::now() + 20s;  // our first task lasts until the others have done all else
    while (runner.tasks_elsewhere() < 39 && std::chrono::steady_clock::now() < give_up) std::this_thread::sleep_for(1ms);
  };
  EXPECT_EQ(chain(runner, counts, at), expected);
  EXPECT_EQ(ours, std::vector<int>{0});
  EXPECT_EQ(runner.tasks_elsewhere(), 39);
  EXPECT_GE(asked, 4) << "not all at once: another's last part must not be long";
}

TEST(ScatteredRunner, ExceptionsOfOurTasksComeOutAndOthersMayStillAnswer) {
  std::atomic<int> asked{0};
  std::vector<std::unique_ptr<OtherInstance>> others;
  others.push_back(std::make_unique<Other>([](TaskRunner& r) { chain(r, {40}); }, [](int) { return Fate::comes_late; }, &asked));
  ScatteredRunner runner(1, std::move(others));
  const auto fail = [](int, int i) {
    if (i == 2) throw std::runtime_error("two");
  };
  EXPECT_THROW(chain(runner, {40}, fail), std::runtime_error);
  ThreadRunner alone(1);
  EXPECT_EQ(chain(runner, {7}), chain(alone, {7}));
}

TEST(ScatteredRunner, WhenTimeIsOutNobodyIsAsked) {
  std::atomic<int> asked{0};
  std::vector<std::unique_ptr<OtherInstance>> others;
  others.push_back(std::make_unique<Other>([](TaskRunner& r) { chain(r, {10}); }, [](int) { return Fate::answers; }, &asked));
  ScatteredRunner runner(1, std::move(others), std::chrono::steady_clock::now() - 1s);
  const auto results = runner.map<int>(10, [](int i, int) { return i; }, 2);
  EXPECT_EQ(runner.tasks(), 2);
  EXPECT_TRUE(results[1].has_value());
  EXPECT_FALSE(results[2].has_value());
  EXPECT_EQ(asked, 0);
}

TEST(RunPart, RefusesWhatIsNoPartOfTheSearch) {
  const Search search = [](TaskRunner& r) { chain(r, {3, 2}); };
  const StageNumbers all = run_part(search, {}, 0, 3, 2);
  ASSERT_EQ(all.sizes, (std::vector<std::uint32_t>{2, 2, 2}));
  const StageNumbers two = run_part(search, {}, 1, 3, 1);
  EXPECT_EQ(two.numbers, Numbers(all.numbers.begin() + 2, all.numbers.end()));
  const auto done = [](const StageNumbers& s) { return StageHistory{std::make_shared<const StageNumbers>(s)}; };
  EXPECT_EQ(run_part(search, done(all), 0, 2, 1).sizes.size(), 2u);
  const auto code = [&](const StageHistory& history, int first, int last) {
    try {
      run_part(search, history, first, last, 1);
      return ErrorCode::ok;
    } catch (const Error& e) {
      return e.code();
    }
  };
  EXPECT_EQ(code({}, 0, 4), ErrorCode::bad_input);
  EXPECT_EQ(code({}, 2, 2), ErrorCode::bad_input);
  EXPECT_EQ(code({}, -1, 2), ErrorCode::bad_input);
  EXPECT_EQ(code(done(two), 0, 1), ErrorCode::bad_size);
  StageNumbers bad = all;
  bad.sizes = {1, 2, 3};
  EXPECT_EQ(code(done(bad), 0, 1), ErrorCode::bad_size);  // of a result
  bad.sizes = {2, 2, 4294967295u};
  EXPECT_EQ(code(done(bad), 0, 1), ErrorCode::bad_size);
  StageHistory three = done(all);
  three.push_back(std::make_shared<const StageNumbers>(run_part(search, done(all), 0, 2, 1)));
  EXPECT_EQ(code(three, 0, 1), ErrorCode::bad_input);  // the search is over by then
}

}  // namespace
}  // namespace periplus::nbv
