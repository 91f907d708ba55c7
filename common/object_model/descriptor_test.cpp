#include "common/object_model/descriptor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/core/error.h"

namespace periplus::object_model {
namespace {

constexpr DescriptorKind kAll[] = {DescriptorKind::root_sift, DescriptorKind::surf, DescriptorKind::akaze, DescriptorKind::orb};

TEST(Descriptor, NumbersAreThoseOfStoredFiles) {
  EXPECT_EQ(descriptor_kind(0), DescriptorKind::root_sift);
  EXPECT_EQ(descriptor_kind(1), DescriptorKind::surf);
  EXPECT_EQ(descriptor_kind(2), DescriptorKind::akaze);
  EXPECT_EQ(descriptor_kind(3), DescriptorKind::orb);
  EXPECT_FALSE(descriptor_kind(4));
  EXPECT_FALSE(descriptor_kind(256));
}

TEST(Descriptor, GradientsAreComparedByEuclideanDistance) {
  std::vector<std::uint8_t> a(128), b(128);
  a[5] = 255;  // two directions at right angles, each half a unit long
  b[9] = 255;
  EXPECT_NEAR(descriptor_distance(DescriptorKind::root_sift, a, b), std::sqrt(2.0) * 255 / 512, 1e-12);
  std::vector<std::uint8_t> c(64, 128), d(64, 128);
  c[0] = 255;
  d[0] = 0;  // opposite signs
  EXPECT_NEAR(descriptor_distance(DescriptorKind::surf, c, d), 255 / 256.0, 1e-12);
}

TEST(Descriptor, BitsAreComparedByHowManyDiffer) {
  std::vector<std::uint8_t> a(32, 0x0f), b(32, 0x0f);
  b[31] = 0x1e;  // two bits
  EXPECT_NEAR(descriptor_distance(DescriptorKind::orb, a, b), 2 / 256.0, 1e-12);
  EXPECT_NEAR(descriptor_distance(DescriptorKind::akaze, std::vector<std::uint8_t>(61, 0xff), std::vector<std::uint8_t>(61, 0)), 1, 1e-12);
}

TEST(Descriptor, OtherLengthsAreRefused) {
  for (const DescriptorKind kind : kAll) {
    const std::vector<std::uint8_t> right(descriptor_octets(kind)), wrong(descriptor_octets(kind) - 1);
    EXPECT_EQ(descriptor_distance(kind, right, right), 0) << to_string(kind);
    EXPECT_THROW(descriptor_distance(kind, right, wrong), Error);
    EXPECT_THROW(descriptor_distance(kind, wrong, wrong), Error);
  }
}

}  // namespace
}  // namespace periplus::object_model
