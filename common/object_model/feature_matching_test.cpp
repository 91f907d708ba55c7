#include "common/object_model/feature_matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::object_model {
namespace {

constexpr DescriptorKind kKinds[] = {DescriptorKind::root_sift, DescriptorKind::surf, DescriptorKind::akaze, DescriptorKind::orb};

// RootSIFT's octets are some 45 on average; bits are even.
std::vector<std::uint8_t> some_descriptor(Random& random, DescriptorKind kind) {
  std::vector<std::uint8_t> d(descriptor_octets(kind));
  for (auto& octet : d) octet = static_cast<std::uint8_t>(random.below(is_binary(kind) ? 256 : 90));
  return d;
}
std::vector<std::uint8_t> disturbed(std::vector<std::uint8_t> d, Random& random, DescriptorKind kind) {
  for (auto& octet : d)
    if (!is_binary(kind))
      octet = static_cast<std::uint8_t>(std::clamp(octet + static_cast<int>(random.below(11)) - 5, 0, 255));
    else if (random.below(4) == 0)
      octet = static_cast<std::uint8_t>(octet ^ (1u << random.below(8)));
  return d;
}

// Two views of a textured plane of 40 x 40 cm, whose second is rotated and moved; `right` features both see, then `wrong` ones that
// look alike 6 cm away or more, then ones that only one sees.
struct TwoViews {
  std::vector<Feature> a, b;
  std::set<std::pair<int, int>> truth;
  TwoViews(DescriptorKind kind, int right, int wrong, std::uint64_t seed) {
    Random random(seed);
    const Pose X = make_pose({0.3, -0.2, 1}, Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix());
    const auto place = [&] { return Eigen::Vector3d(0.4 * random.uniform(), 0.4 * random.uniform(), 0); };
    const auto noise = [&] { return Eigen::Vector3d(0.004 * (random.uniform() - 0.5), 0.004 * (random.uniform() - 0.5), 0.004 * (random.uniform() - 0.5)); };
    const auto add = [&](std::vector<Feature>& to, const Eigen::Vector3d& p, std::vector<std::uint8_t> descriptor) {
      Feature f;
      f.p_W = p;
      f.kind = kind;
      f.descriptor = std::move(descriptor);
      to.push_back(std::move(f));
    };
    for (int i = 0; i < right + wrong; ++i) {
      const Eigen::Vector3d p = place();
      const std::vector<std::uint8_t> d = some_descriptor(random, kind);
      add(a, p + noise(), d);
      Eigen::Vector3d q = p;
      while (i >= right && (q - p).norm() < 0.06) q = place();
      add(b, X * Eigen::Vector3d(q + noise()), disturbed(d, random, kind));
      if (i < right) truth.insert({i, i});
    }
    for (int i = 0; i < 30; ++i) {
      add(a, place(), some_descriptor(random, kind));
      add(b, X * place(), some_descriptor(random, kind));
    }
  }
};

std::set<std::pair<int, int>> pairs(const std::vector<FeatureMatch>& matches, bool exchanged = false) {
  std::set<std::pair<int, int>> out;
  for (const FeatureMatch& m : matches) out.insert(exchanged ? std::pair(m.b, m.a) : std::pair(m.a, m.b));
  return out;
}

TEST(FeatureMatching, FindsWhatBothViewsShow) {
  for (const DescriptorKind kind : kKinds) {
    const TwoViews v(kind, 60, 0, 1);
    EXPECT_EQ(pairs(match_views(v.a, v.b)), v.truth) << to_string(kind);
  }
}

TEST(FeatureMatching, DistancesInSpaceTellWrongPairsThatLookAlike) {
  for (const DescriptorKind kind : kKinds)
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const TwoViews v(kind, 50, 30, seed);
      MatchingSettings blind;
      blind.least_coherent = 0;
      blind.coherent_share = 0;
      EXPECT_EQ(match_views(v.a, v.b, blind).size(), 80u);
      const auto found = pairs(match_views(v.a, v.b));
      int wrong = 0, right = 0;
      for (const auto& p : found) (v.truth.contains(p) ? right : wrong) += 1;
      EXPECT_EQ(right, 50) << to_string(kind) << " " << seed;
      EXPECT_LE(wrong, 1) << to_string(kind) << " " << seed;
    }
}

TEST(FeatureMatching, AFewThatAgreeByChanceAreNoMatches) {
  const TwoViews v(DescriptorKind::root_sift, 0, 40, 7);
  EXPECT_LE(match_views(v.a, v.b).size(), 6u);
  const TwoViews three(DescriptorKind::root_sift, 3, 0, 7);  // each has two others
  EXPECT_TRUE(match_views(three.a, three.b).empty());
  const TwoViews four(DescriptorKind::root_sift, 4, 0, 7);
  EXPECT_EQ(match_views(four.a, four.b).size(), 4u);
}

TEST(FeatureMatching, IsSymmetricAndBlindToTheOrderOfFeatures) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const TwoViews v(kKinds[seed % 4], 25, 20, seed);
    const auto found = pairs(match_views(v.a, v.b));
    EXPECT_EQ(pairs(match_views(v.b, v.a), true), found);
    std::vector<Feature> reversed(v.a.rbegin(), v.a.rend());
    std::set<std::pair<int, int>> again;
    for (const auto& [i, j] : pairs(match_views(reversed, v.b))) again.insert({static_cast<int>(v.a.size()) - 1 - i, j});
    EXPECT_EQ(again, found);
  }
}

// Line by line as the thesis has it.
TEST(FeatureMatching, IsTheThesisAlgorithm6BeforeDistances) {
  MatchingSettings s;
  s.least_coherent = 0;
  s.coherent_share = 0;
  s.ratio = 0.95;
  for (const DescriptorKind kind : kKinds) {
    Random random(static_cast<std::uint64_t>(kind) + 5);
    std::vector<Feature> a(40), b(50);
    for (auto* view : {&a, &b})
      for (Feature& f : *view) {
        f.kind = kind;
        f.descriptor = some_descriptor(random, kind);
        for (std::size_t i = 8; i < f.descriptor.size(); ++i) f.descriptor[i] = 20;  // few octets differ: some come near
      }
    const auto list = [&](const std::vector<Feature>& from, const std::vector<Feature>& to) {
      std::vector<int> m(from.size(), -1);
      for (std::size_t i = 0; i < from.size(); ++i) {
        double best = 1e9, second = 1e9;
        int at = -1;
        for (std::size_t j = 0; j < to.size(); ++j) {
          const double d = descriptor_distance(kind, from[i].descriptor, to[j].descriptor);
          if (d < best) {
            second = best;
            best = d;
            at = static_cast<int>(j);
          } else {
            second = std::min(second, d);
          }
        }
        if (best <= (is_binary(kind) ? s.most_bits : s.most_distance) && best < s.ratio * second) m[i] = at;
      }
      return m;
    };
    const std::vector<int> m12 = list(a, b), m21 = list(b, a);
    std::set<std::pair<int, int>> expected;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (m12[i] >= 0 && m21[static_cast<std::size_t>(m12[i])] == static_cast<int>(i)) expected.insert({static_cast<int>(i), m12[i]});
    EXPECT_GT(expected.size(), 3u);
    EXPECT_EQ(pairs(match_views(a, b, s)), expected) << to_string(kind);
  }
}

TEST(FeatureMatching, KindsAndLengthsAreNotMixed) {
  const TwoViews sift(DescriptorKind::root_sift, 20, 0, 3);
  TwoViews orb(DescriptorKind::orb, 20, 0, 3);
  EXPECT_TRUE(match_views(sift.a, orb.b).empty());
  EXPECT_EQ(match_views(orb.a, orb.b).size(), 20u);
  for (Feature& f : orb.b) f.descriptor.push_back(0);
  EXPECT_TRUE(match_views(orb.a, orb.b).empty());
  EXPECT_TRUE(match_views({}, orb.b).empty());
}

TEST(FeatureMatching, TheBestComeFirstAndAtMostAsManyAsAsked) {
  const TwoViews v(DescriptorKind::root_sift, 40, 0, 9);
  const auto all = match_views(v.a, v.b);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), [](const auto& x, const auto& y) { return x.distance < y.distance; }));
  MatchingSettings few;
  few.most = 12;
  EXPECT_EQ(match_views(v.a, v.b, few), std::vector<FeatureMatch>(all.begin(), all.begin() + 12));
  EXPECT_NEAR(all[0].distance, descriptor_distance(DescriptorKind::root_sift, v.a[static_cast<std::size_t>(all[0].a)].descriptor, v.b[static_cast<std::size_t>(all[0].b)].descriptor), 1e-12);
}

TEST(FeatureMatching, SettingsOutOfRangeAreRefused) {
  for (const auto spoil : {+[](MatchingSettings& s) { s.ratio = 0; }, +[](MatchingSettings& s) { s.most_bits = 2; }, +[](MatchingSettings& s) { s.coherent_share = 1.1; },
                           +[](MatchingSettings& s) { s.distance_m = -1; }, +[](MatchingSettings& s) { s.most = -1; }}) {
    MatchingSettings s;
    spoil(s);
    EXPECT_THROW(match_views({}, {}, s), Error);
  }
}

}  // namespace
}  // namespace periplus::object_model
