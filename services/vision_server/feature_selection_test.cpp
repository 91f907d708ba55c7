#include "services/vision_server/feature_selection.h"

#include <gtest/gtest.h>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::vision {
namespace {

// Features by hand: octet `value` everywhere makes a descriptor, whose distance to another is |difference| * sqrt(128) / 512.
struct Eyes {
  DetectedFeatures left, right;
  std::vector<double> disparity;
  static void add(DetectedFeatures& to, float u, float v, float size, std::uint8_t value) {
    Keypoint k;
    k.u = u;
    k.v = v;
    k.size = size;
    k.response = 0.05f;
    to.points.push_back(k);
    to.descriptors.insert(to.descriptors.end(), object_model::descriptor_octets(to.kind), value);
  }
  std::vector<SelectedFeature> select(FeatureSelection method, SelectionSettings s = {}) const {
    s.method = method;
    return select_features(left, right, disparity, s);
  }
};

constexpr FeatureSelection kAlgorithm4 = FeatureSelection::geometry_first, kAlgorithm5 = FeatureSelection::descriptor_first, kAlone = FeatureSelection::left_alone;

// One left feature at (100, 50) with disparity 30, and its counterpart in the right eye.
Eyes one_pair() {
  Eyes e;
  Eyes::add(e.left, 100, 50, 6, 40);
  e.disparity = {30};
  Eyes::add(e.right, 70.4f, 50.5f, 7, 42);
  return e;
}

TEST(FeatureSelection, KeepsAPairThatFitsInEveryWay) {
  const Eyes e = one_pair();
  for (const FeatureSelection method : {kAlgorithm4, kAlgorithm5}) {
    const auto found = e.select(method);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].left, 0u);
    EXPECT_EQ(found[0].right, 0u);
    EXPECT_NEAR(found[0].disparity, 29.6, 1e-5);
    EXPECT_NEAR(found[0].distance, 2 * std::sqrt(128.0) / 512, 1e-12);
  }
  ASSERT_EQ(e.select(kAlone).size(), 1u);
  EXPECT_EQ(e.select(kAlone)[0].disparity, 30);
}

TEST(FeatureSelection, EachGeometricTestRefusesByItself) {
  struct Case {
    const char* what;
    void (*spoil)(Eyes&);
    bool of_pairs;  // left_alone does not ask for it
  };
  for (const Case& c : {Case{"off the epipolar line", [](Eyes& e) { e.right.points[0].v = 52.5f; }, true},
                        Case{"another disparity", [](Eyes& e) { e.right.points[0].u = 72; }, true},
                        Case{"another disparity, the other way", [](Eyes& e) { e.right.points[0].u = 68; }, true},
                        Case{"larger in the right eye", [](Eyes& e) { e.right.points[0].size = 9.5f; }, true},
                        Case{"larger in the left eye", [](Eyes& e) { e.left.points[0].size = 11; }, true},
                        Case{"too small", [](Eyes& e) { e.left.points[0].size = e.right.points[0].size = 2; }, false},
                        Case{"too large", [](Eyes& e) { e.left.points[0].size = e.right.points[0].size = 60; }, false},
                        Case{"not on the object", [](Eyes& e) { e.disparity[0] = 0; }, false},
                        Case{"no right features", [](Eyes& e) { e.right = {}; }, true}}) {
    Eyes e = one_pair();
    c.spoil(e);
    EXPECT_TRUE(e.select(kAlgorithm4).empty()) << c.what;
    EXPECT_TRUE(e.select(kAlgorithm5).empty()) << c.what;
    EXPECT_EQ(e.select(kAlone).size(), c.of_pairs ? 1u : 0u) << c.what;
  }
  SelectionSettings strong;
  strong.response_min = 0.06;
  for (const FeatureSelection method : {kAlgorithm4, kAlgorithm5, kAlone}) EXPECT_TRUE(one_pair().select(method, strong).empty());
}

// Where the two differ: a better match elsewhere, and a second candidate at the right place.
TEST(FeatureSelection, Algorithm5AsksWhetherADescriptorTellsAtAll) {
  Eyes e = one_pair();
  Eyes::add(e.right, 300, 90, 6, 40);  // looks exactly like it, far away
  EXPECT_EQ(e.select(kAlgorithm4).size(), 1u);
  EXPECT_TRUE(e.select(kAlgorithm5).empty());
}

TEST(FeatureSelection, Algorithm4AsksForAClearOneAmongThoseThatFit) {
  Eyes e = one_pair();                      // 2 away
  Eyes::add(e.right, 70, 50.6f, 6, 43);     // 3 away: 2 / 3 of it
  EXPECT_TRUE(e.select(kAlgorithm4).empty());
  EXPECT_EQ(e.select(kAlgorithm5).size(), 1u);
  SelectionSettings s;
  s.second_ratio = 0.7;
  ASSERT_EQ(e.select(kAlgorithm4, s).size(), 1u);
  EXPECT_EQ(e.select(kAlgorithm4, s)[0].right, 0u);
  // And for one that is like it at all.
  Eyes unlike = one_pair();
  unlike.right.descriptors.assign(128, 90);  // 50 * sqrt(128) / 512 = 1.1
  EXPECT_TRUE(unlike.select(kAlgorithm4).empty());
  EXPECT_EQ(unlike.select(kAlgorithm5).size(), 1u);
}

TEST(FeatureSelection, BitsAreComparedByHamming) {
  Eyes e;
  e.left.kind = e.right.kind = DescriptorKind::orb;
  Eyes::add(e.left, 100, 50, 31, 0x0f);
  e.disparity = {30};
  Eyes::add(e.right, 70, 50, 31, 0x10);      // five bits of eight differ, though the octets are neighbours
  Eyes::add(e.right, 300, 60, 31, 0x8f);     // one bit of eight
  EXPECT_TRUE(e.select(kAlgorithm5).empty());
  EXPECT_TRUE(e.select(kAlgorithm4).empty());
  SelectionSettings s;
  s.most_bits = 0.7;
  ASSERT_EQ(e.select(kAlgorithm4, s).size(), 1u);
  EXPECT_NEAR(e.select(kAlgorithm4, s)[0].distance, 5 / 8.0, 1e-12);
}

// Against a search over all pairs, line by line.
TEST(FeatureSelection, IsWhatASearchOverAllPairsFinds) {
  Random random(6);
  Eyes e;
  for (int i = 0; i < 150; ++i) {
    const auto v = static_cast<float>(0.4 * i + random.uniform(0, 0.3));  // in ascending order, as detectors give them
    Eyes::add(e.right, static_cast<float>(random.uniform(0, 40)), v, static_cast<float>(random.uniform(4, 8)), static_cast<std::uint8_t>(random.below(250)));
  }
  for (int i = 0; i < 150; ++i) {
    Eyes::add(e.left, static_cast<float>(random.uniform(10, 50)), static_cast<float>(random.uniform(0, 60)), static_cast<float>(random.uniform(1, 9)),
              static_cast<std::uint8_t>(random.below(250)));
    // Every other one has a counterpart.
    const Keypoint r = e.right.points[static_cast<std::size_t>(i)];
    if (i % 2) {
      e.left.points.back().v = r.v + 1;
      e.left.points.back().u = r.u + 10;
      std::fill_n(e.left.descriptors.end() - 128, 128, static_cast<std::uint8_t>(e.right.descriptor(static_cast<std::size_t>(i))[0] + random.below(3)));
    }
    e.disparity.push_back(random.below(5) ? random.uniform(7, 13) : 0);
  }
  SelectionSettings s;
  s.stereo_px = 4;
  s.size_min_px = 3;
  for (const FeatureSelection method : {kAlgorithm4, kAlgorithm5}) {
    std::vector<std::pair<std::size_t, std::size_t>> expected, found;
    for (std::size_t i = 0; i < e.left.points.size(); ++i) {
      const Keypoint& l = e.left.points[i];
      if (!(l.size > 3 && l.size < 60) || e.disparity[i] <= 0) continue;
      double best = 1e9, second = 1e9;
      std::size_t at = 0;
      const auto fits = [&](const Keypoint& r) {
        return std::abs(r.v - l.v) <= 4 && std::abs(l.u - r.u - e.disparity[i]) <= 4 && std::max(l.size / r.size, r.size / l.size) <= 1.5f;
      };
      for (std::size_t j = 0; j < e.right.points.size(); ++j) {
        if (method == kAlgorithm4 && !fits(e.right.points[j])) continue;
        const double d = object_model::descriptor_distance(DescriptorKind::root_sift, e.left.descriptor(i), e.right.descriptor(j));
        if (d < best) {
          second = best;
          best = d;
          at = j;
        } else {
          second = std::min(second, d);
        }
      }
      if (method == kAlgorithm4 ? best <= s.most_distance && best < 0.5 * second : fits(e.right.points[at])) expected.emplace_back(i, at);
    }
    for (const SelectedFeature& f : e.select(method, s)) found.emplace_back(f.left, f.right);
    EXPECT_GT(found.size(), 5u);
    EXPECT_EQ(found, expected);
  }
}

TEST(FeatureSelection, RefusesWhatDoesNotBelongTogether) {
  Eyes e = one_pair();
  e.disparity.push_back(1);
  EXPECT_THROW(e.select(kAlgorithm5), Error);
  e = one_pair();
  e.right.kind = DescriptorKind::orb;
  EXPECT_THROW(e.select(kAlgorithm5), Error);
  SelectionSettings s;
  s.scale_ratio = 0.9;
  EXPECT_THROW(one_pair().select(kAlgorithm4, s), Error);
}

}  // namespace
}  // namespace periplus::vision
