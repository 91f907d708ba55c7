#include "services/vision_server/feature_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "common/core/error.h"
#include "common/core/random.h"
#include "services/vision_server/testing/opencv_threads.h"

namespace periplus::vision {
namespace {

// Soft blobs of many sizes and directions on grey.
ImageU8 blobs(int width, int height, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> sum(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 120);
  for (int n = 0; n < 90; ++n) {
    const double cx = random.uniform(0, width), cy = random.uniform(0, height), s = random.uniform(2, 7), stretch = random.uniform(1, 2), turn = random.uniform(0, 3.1),
                 height_of = random.uniform(40, 90) * (n % 2 ? 1 : -1);
    const int reach = static_cast<int>(4 * s * stretch);
    for (int y = std::max(0, static_cast<int>(cy) - reach); y < std::min(height, static_cast<int>(cy) + reach); ++y)
      for (int x = std::max(0, static_cast<int>(cx) - reach); x < std::min(width, static_cast<int>(cx) + reach); ++x) {
        const double a = std::cos(turn) * (x - cx) + std::sin(turn) * (y - cy), b = -std::sin(turn) * (x - cx) + std::cos(turn) * (y - cy);
        sum[static_cast<std::size_t>(y * width + x)] += height_of * std::exp(-(a * a / (stretch * stretch) + b * b) / (2 * s * s));
      }
  }
  ImageU8 out(width, height);
  for (std::size_t i = 0; i < sum.size(); ++i) out.data[i] = static_cast<std::uint8_t>(std::clamp(std::lround(sum[i]), 0l, 255l));
  return out;
}

ImageU8 turned_by_a_quarter(const ImageU8& image) {
  ImageU8 out(image.height, image.width);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) out.at(image.height - 1 - y, x) = image.at(x, y);
  return out;
}

const ImageU8 kEverywhere(200, 160, 1, 255);

DetectorSettings of_kind(DescriptorKind kind) {
  DetectorSettings s;
  s.kind = kind;
  return s;
}
constexpr DescriptorKind kHere[] = {DescriptorKind::root_sift, DescriptorKind::akaze, DescriptorKind::orb};

TEST(FeatureDetector, FeaturesTurnWithTheImage) {
  const ImageU8 image = blobs(200, 160, 2), turned = turned_by_a_quarter(image);
  for (const DescriptorKind kind : kHere) {
    const DetectedFeatures a = detect_features(image, kEverywhere, of_kind(kind)), b = detect_features(turned, ImageU8(160, 200, 1, 255), of_kind(kind));
    ASSERT_GT(a.points.size(), 20u) << to_string(kind);
    ASSERT_EQ(a.descriptors.size(), a.points.size() * object_model::descriptor_octets(kind));
    // The nearest by descriptor is the one at the turned place with the turned angle.
    int right = 0;
    for (std::size_t i = 0; i < a.points.size(); ++i) {
      double best = 1e9;
      std::size_t at = 0;
      for (std::size_t j = 0; j < b.points.size(); ++j)
        if (const double d = object_model::descriptor_distance(kind, a.descriptor(i), b.descriptor(j)); d < best) best = d, at = j;
      const Keypoint &k = a.points[i], &l = b.points[at];
      right += std::hypot(l.u - (159 - k.v), l.v - k.u) < 2 && std::abs(std::remainder(l.angle - k.angle - std::numbers::pi / 2, 2 * std::numbers::pi)) < 0.2;
    }
    EXPECT_GT(right, 0.8 * static_cast<double>(a.points.size())) << to_string(kind);
  }
}

TEST(FeatureDetector, RootSiftHasLength512) {
  const DetectedFeatures f = detect_features(blobs(200, 160, 3), kEverywhere, {});
  ASSERT_GT(f.points.size(), 20u);
  for (std::size_t i = 0; i < f.points.size(); ++i) {
    double squares = 0;
    for (const auto v : f.descriptor(i)) squares += static_cast<double>(v) * v;
    EXPECT_NEAR(std::sqrt(squares), 512, 12);
  }
}

TEST(FeatureDetector, KeepsToTheMaskAndFindsFainterOnesWhenAsked) {
  const ImageU8 image = blobs(200, 160, 4);
  ImageU8 left_half(200, 160);
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 100; ++x) left_half.at(x, y) = 255;
  for (const DescriptorKind kind : kHere) {
    const std::size_t all = detect_features(image, kEverywhere, of_kind(kind)).points.size();
    for (const Keypoint& k : detect_features(image, left_half, of_kind(kind)).points) EXPECT_LT(k.u, 101) << to_string(kind);
    EXPECT_GE(detect_features(image, kEverywhere, of_kind(kind), 4).points.size(), all) << to_string(kind);
    EXPECT_TRUE(detect_features(image, ImageU8(200, 160), of_kind(kind)).points.empty()) << to_string(kind);
    EXPECT_TRUE(detect_features(ImageU8(200, 160, 1, 90), kEverywhere, of_kind(kind)).points.empty()) << to_string(kind);
  }
}

TEST(FeatureDetector, IsTheSameForAnyNumberOfThreads) {
  const ImageU8 image = blobs(400, 320, 5), everywhere(400, 320, 1, 255);
  for (const DescriptorKind kind : kHere) {
    const auto with = [&](int threads) {
      const testing::OpenCvThreads set(threads);
      return detect_features(image, everywhere, of_kind(kind));
    };
    const DetectedFeatures one = with(1), four = with(4);
    EXPECT_EQ(one.descriptors, four.descriptors) << to_string(kind);
    ASSERT_EQ(one.points.size(), four.points.size());
    const auto key = [](const Keypoint& k) { return std::tuple(k.v, k.u, k.size, k.angle); };
    for (std::size_t i = 0; i < one.points.size(); ++i) EXPECT_EQ(key(one.points[i]), key(four.points[i]));
    EXPECT_TRUE(std::is_sorted(one.points.begin(), one.points.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); }));
  }
}

TEST(FeatureDetector, SurfIsThereOrSaysWhyNot) {
  const std::string reason = unavailable(DescriptorKind::surf);
  if (reason.empty()) {
    const DetectedFeatures f = detect_features(blobs(200, 160, 2), kEverywhere, of_kind(DescriptorKind::surf));
    EXPECT_EQ(f.descriptors.size(), f.points.size() * 64);
    EXPECT_GT(f.points.size(), 10u);
    return;
  }
  EXPECT_NE(reason.find("OPENCV_ENABLE_NONFREE"), std::string::npos);
  EXPECT_NE(reason.find("akaze"), std::string::npos);
  try {
    of_kind(DescriptorKind::surf).check();
    FAIL() << "SURF was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
  }
}

TEST(FeatureDetector, RefusesMasksOfAnotherSize) {
  EXPECT_THROW(detect_features(ImageU8(20, 20), ImageU8(20, 21), {}), Error);
  EXPECT_THROW(detect_features(ImageU8(20, 20), ImageU8(20, 20), {}, 0), Error);
}

}  // namespace
}  // namespace periplus::vision
