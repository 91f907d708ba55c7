#include "services/nbv_planner/local_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "common/core/error.h"

namespace periplus::nbv {
namespace {

constexpr LocalMethod kMethods[] = {LocalMethod::bobyqa, LocalMethod::newuoa, LocalMethod::nelder_mead};

LocalSearchOptions options(int n, double step, int evaluations, LocalMethod method = LocalMethod::bobyqa) {
  return {std::vector<double>(n, step), std::vector<double>(n, -2), std::vector<double>(n, 2), 1e-6, evaluations, method};
}

TEST(LocalSearch, FindsTheMinimumOfABowl) {
  const auto bowl = [](const std::vector<double>& x) {
    double f = 0;
    for (std::size_t i = 0; i < x.size(); ++i) f += (1.0 + double(i)) * std::pow(x[i] - 0.3 * double(i), 2);
    return f;
  };
  for (const LocalMethod method : kMethods) {
    const int budget = method == LocalMethod::nelder_mead ? 1000 : 200;
    LocalSearchOptions o = options(5, 0.3, budget, method);
    o.step = {0.1, 0.2, 0.3, 0.4, 0.5};  // NEWUOA's variables are scaled by them
    const LocalSearchResult r = minimize(bowl, std::vector<double>(5, 1), o);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(r.x[i], 0.3 * i, 1e-4) << static_cast<int>(method);
    EXPECT_LE(r.evaluations, budget);
  }
}

TEST(LocalSearch, OnlyNewuoaLeavesTheBounds) {
  const auto away = [](const std::vector<double>& x) { return std::pow(x[0] - 3, 2) + std::pow(x[1] - 1, 2); };
  for (const LocalMethod method : kMethods) {
    const LocalSearchResult r = minimize(away, {0, 0}, options(2, 0.5, 400, method));
    EXPECT_NEAR(r.x[0], method == LocalMethod::newuoa ? 3 : 2, 1e-3);
    EXPECT_NEAR(r.x[1], 1, 1e-3);
  }
}

TEST(LocalSearch, StaysWithinBoundsBudgetAndNeverLosesTheBest) {
  int calls = 0;
  double least = 1e300;
  const auto steps = [&](const std::vector<double>& x) {  // a staircase, like N_u
    ++calls;
    for (double v : x) EXPECT_LE(std::abs(v), 2);
    const double f = std::floor(10 * (x[0] + x[1]));
    least = std::min(least, f);
    return f;
  };
  for (const LocalMethod method : {LocalMethod::bobyqa, LocalMethod::nelder_mead}) {
    calls = 0;
    least = 1e300;
    const LocalSearchResult r = minimize(steps, {5, 0}, options(2, 0.5, 40, method));
    EXPECT_LE(calls, 40);
    EXPECT_EQ(r.evaluations, calls);
    EXPECT_EQ(r.value, least);
    EXPECT_LT(r.value, 0);
  }
}

TEST(LocalSearch, TooSmallABudgetReturnsTheStart) {
  const LocalSearchResult r = minimize([](const std::vector<double>& x) { return x[0]; }, {0.5, 0.5}, options(2, 0.1, 6));
  EXPECT_EQ(r.evaluations, 1);
  EXPECT_EQ(r.x, (std::vector<double>{0.5, 0.5}));
}

TEST(LocalSearch, ExceptionsPassAndBadInputIsRefused) {
  const auto throws = [](const std::vector<double>&) -> double { throw std::runtime_error("lost"); };
  EXPECT_THROW(minimize(throws, {0, 0}, options(2, 0.1, 40)), std::runtime_error);
  EXPECT_THROW(minimize([](const std::vector<double>&) { return 0.0; }, {0, 0}, options(3, 0.1, 40)), Error);
}

}  // namespace
}  // namespace periplus::nbv
