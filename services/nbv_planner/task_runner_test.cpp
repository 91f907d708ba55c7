#include "services/nbv_planner/task_runner.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "common/geometry/camera.h"

namespace periplus::nbv {
namespace {

enum class Kind { first, second };
struct Inner {
  std::vector<std::optional<int>> counts;
};
template <class Fields>
void visit_fields(Fields& fields, Inner& i) {
  fields(i.counts);
}
struct Everything {
  Pose X = Pose::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  double real = 0;
  float small = 0;
  int whole = 0;
  std::uint64_t large = 0;
  std::int64_t negative = 0;
  bool yes = false;
  Kind kind = Kind::first;
  std::vector<Inner> inner;
};
template <class Fields>
void visit_fields(Fields& fields, Everything& e) {
  fields(e.X, e.p, e.real, e.small, e.whole, e.large, e.negative, e.yes, e.kind, e.inner);
}

Everything example() {
  Everything e;
  e.X = make_pose({0.1, -0.2, 1 / 3.0}, Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix());
  e.p = {1e-300, -0.0, std::numeric_limits<double>::infinity()};
  e.real = std::nextafter(std::numbers::pi, 4.0);
  e.small = 0.1f;
  e.whole = -2147483647 - 1;
  e.large = 0xffffffffffffffffULL - 5;
  e.negative = -(std::int64_t{1} << 60) - 1;
  e.yes = true;
  e.kind = Kind::second;
  e.inner = {{{1, std::nullopt, 3}}, {}};
  return e;
}

TEST(TaskNumbers, AreReadBackBitForBit) {
  Everything e = example();
  Numbers numbers;
  append_numbers(e, numbers);
  const Everything r = from_numbers<Everything>(numbers);
  EXPECT_EQ(0, std::memcmp(e.X.matrix().data(), r.X.matrix().data(), 16 * sizeof(double)));
  EXPECT_EQ(0, std::memcmp(e.p.data(), r.p.data(), 3 * sizeof(double)));  // the zero keeps its sign
  EXPECT_EQ(e.real, r.real);
  EXPECT_EQ(e.small, r.small);
  EXPECT_EQ(e.whole, r.whole);
  EXPECT_EQ(e.large, r.large);
  EXPECT_EQ(e.negative, r.negative);
  EXPECT_EQ(e.yes, r.yes);
  EXPECT_EQ(e.kind, r.kind);
  ASSERT_EQ(r.inner.size(), 2u);
  EXPECT_EQ(r.inner[0].counts, e.inner[0].counts);
  EXPECT_TRUE(r.inner[1].counts.empty());
}

TEST(TaskNumbers, RefuseWhatTheFieldsCannotHold) {
  Everything e = example();
  Numbers good;
  append_numbers(e, good);
  const auto code = [](const Numbers& numbers) {
    try {
      from_numbers<Everything>(numbers);
      return ErrorCode::ok;
    } catch (const Error& error) {
      return error.code();
    }
  };
  EXPECT_EQ(code(good), ErrorCode::ok);
  for (std::size_t n = 0; n < good.size(); ++n) {
    EXPECT_EQ(code(Numbers(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(n))), ErrorCode::bad_size) << n;
  }
  Numbers bad = good;
  bad.push_back(0);
  EXPECT_EQ(code(bad), ErrorCode::bad_size);
  constexpr std::size_t kWhole = 17, kSize = 24;  // `whole`; the number of `inner`
  for (const double value : {0.5, 3e9, std::nan(""), std::numeric_limits<double>::infinity()}) {
    bad = good;
    bad[kWhole] = value;
    EXPECT_EQ(code(bad), ErrorCode::bad_input) << value;
    bad = good;
    bad[kSize] = value;
    EXPECT_EQ(code(bad), value == 3e9 ? ErrorCode::bad_size : ErrorCode::bad_input) << value;
  }
}

std::vector<std::optional<int>> squares(TaskRunner& runner, int count, int at_least = 0) {
  return runner.map<int>(count, [](int i, int) { return i * i; }, at_least);
}

TEST(ThreadRunner, GivesAllResultsInOrderOnAnyNumberOfThreads) {
  for (const int threads : {0, 1, 2, 5}) {
    ThreadRunner runner(threads);
    EXPECT_GE(runner.workers(), 1);
    for (const int count : {0, 1, 3, 100}) {
      const auto results = squares(runner, count);
      ASSERT_EQ(static_cast<int>(results.size()), count);
      for (int i = 0; i < count; ++i) EXPECT_EQ(results[i], i * i);
    }
  }
}

TEST(ThreadRunner, AWorkerRunsOneTaskAtATime) {
  ThreadRunner runner(4);
  std::vector<std::atomic<int>> busy(runner.workers());
  std::atomic<bool> shared{false};
  runner.map<int>(2000, [&](int i, int worker) {
    if (busy[worker]++ > 0) shared = true;
    --busy[worker];
    return i;
  });
  EXPECT_FALSE(shared);
}

TEST(ThreadRunner, ExceptionsOfTasksComeOut) {
  ThreadRunner runner(3);
  const auto fail = [](int i, int) -> int { return i == 7 ? throw std::runtime_error("seven") : i; };
  EXPECT_THROW(runner.map<int>(20, fail), std::runtime_error);
}

TEST(ThreadRunner, WhenTimeIsOutOnlyTheLeastIsDone) {
  ThreadRunner runner(2, std::chrono::steady_clock::now() - std::chrono::seconds(1));
  EXPECT_TRUE(runner.out_of_time());
  const auto results = squares(runner, 10, 3);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(results[i].has_value(), i < 3) << i;
  ThreadRunner in_time(2, std::chrono::steady_clock::now() + std::chrono::hours(1));
  EXPECT_FALSE(in_time.out_of_time());
  EXPECT_TRUE(squares(in_time, 10).back().has_value());
}

}  // namespace
}  // namespace periplus::nbv
