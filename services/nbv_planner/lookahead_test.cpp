#include "services/nbv_planner/lookahead.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::nbv {
namespace {

ViewPromise promise(std::uint32_t from, std::uint32_t to, double penalty = 0) {
  ViewPromise p;
  for (std::uint32_t v = from; v < to; ++v) p.voxels.push_back(v);
  p.value = double(to - from) - penalty;
  return p;
}

TEST(Lookahead, GreedyLosesWhereTwoHalvesCoverAll) {
  // The middle shows the most, but leaves two rests that no single view shows; left and right cover all in two.
  const std::vector<ViewPromise> views{promise(22, 78), promise(0, 50), promise(50, 100)};
  LookaheadSettings s;
  s.within = 0.2;
  EXPECT_EQ(look_ahead(views, {}, s).first, 0);  // depth 1 is greedy
  s.depth = 2;
  const LookaheadChoice two = look_ahead(views, {}, s);
  EXPECT_EQ(two.first, 1);
  EXPECT_EQ(two.then, std::vector<int>{2});
  EXPECT_NEAR(two.total, 50 + 0.9 * 50, 1e-9);
  s.discount = 0.1;  // later views hardly count: what is there now decides
  EXPECT_EQ(look_ahead(views, {}, s).first, 0);
  s.discount = 0.9;
  s.within = 0.05;   // 50 is not within 5 % of 56
  EXPECT_EQ(look_ahead(views, {}, s).first, 0);
}

TEST(Lookahead, ThirdViewDecides) {
  // 0 and 1 are the best pair and leave a rest at each end, but 2, 3 and 4 cover everything in three.
  const std::vector<ViewPromise> views{promise(10, 60), promise(60, 110), promise(0, 40), promise(40, 80), promise(80, 120)};
  LookaheadSettings s;
  s.depth = 3;
  s.discount = 1;
  s.within = 1;
  const LookaheadChoice c = look_ahead(views, {}, s);
  EXPECT_NEAR(c.total, 120, 1e-9);
  std::set<int> taken(c.then.begin(), c.then.end());
  taken.insert(c.first);
  EXPECT_EQ(taken, (std::set<int>{2, 3, 4}));
}

TEST(Lookahead, PenaltiesAndWeightsCount) {
  std::vector<ViewPromise> views{promise(0, 50), promise(50, 100, 30), promise(50, 90)};
  LookaheadSettings s;
  s.depth = 2;
  s.within = 1;
  // A later view is judged by what it shows alone; the first one pays its penalty.
  EXPECT_EQ(look_ahead(views, {}, s).first, 0);
  EXPECT_EQ(look_ahead(views, {}, s).then, std::vector<int>{1});
  std::vector<float> weights(100, 1);
  for (int v = 90; v < 100; ++v) weights[static_cast<std::size_t>(v)] = 0;
  const LookaheadChoice weighted = look_ahead(views, weights, s);
  EXPECT_EQ(weighted.then, std::vector<int>{2});  // 1 adds as much now, but is worth less by itself
  EXPECT_NEAR(weighted.total, 50 + 0.9 * 40, 1e-6);
}

// Against every sequence, with sets of the library.
TEST(Lookahead, AgreesWithAllSequences) {
  Random random(3);
  for (int round = 0; round < 40; ++round) {
    std::vector<float> weights(150);
    for (float& w : weights) w = round % 2 == 0 ? 1.0f : static_cast<float>(random.below(8)) / 4;
    std::vector<ViewPromise> views(7);
    for (ViewPromise& v : views) {
      for (std::uint32_t k = 0; k < 150; ++k) {
        if (random.uniform() < 0.3) v.voxels.push_back(k);
      }
      for (const std::uint32_t k : v.voxels) v.value += weights[k];
      v.value -= random.uniform(0, 5);
    }
    LookaheadSettings s;
    s.depth = 2 + round % 2;
    s.within = round % 3 == 0 ? 0.1 : 1;
    double best = -1, greatest = -1;
    for (const ViewPromise& v : views) greatest = std::max(greatest, v.value);
    for (int a = 0; a < 7; ++a) {
      if (views[static_cast<std::size_t>(a)].value < greatest * (1 - s.within)) continue;
      for (int b = 0; b < 7; ++b) {
        for (int c = 0; c < 7; ++c) {
          std::set<std::uint32_t> seen(views[static_cast<std::size_t>(a)].voxels.begin(), views[static_cast<std::size_t>(a)].voxels.end());
          double total = views[static_cast<std::size_t>(a)].value, factor = s.discount;
          for (const int next : {b, c}) {
            if (next == c && s.depth == 2) break;
            for (const std::uint32_t k : views[static_cast<std::size_t>(next)].voxels) {
              if (seen.insert(k).second) total += factor * weights[k];
            }
            factor *= s.discount;
          }
          best = std::max(best, total);
        }
      }
    }
    EXPECT_NEAR(look_ahead(views, round % 2 == 0 ? std::vector<float>{} : weights, s).total, best, 1e-4) << round;
  }
}

TEST(Lookahead, BadOnesAreRefused) {
  EXPECT_THROW(look_ahead({}, {}, {}), Error);
  LookaheadSettings s;
  s.depth = 4;
  EXPECT_THROW(look_ahead({promise(0, 3)}, {}, s), Error);
  EXPECT_EQ(look_ahead({promise(0, 3)}, {}, {}).first, 0);
}

}  // namespace
}  // namespace periplus::nbv
