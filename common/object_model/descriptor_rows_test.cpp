#include "common/object_model/descriptor_rows.h"

#include <gtest/gtest.h>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::object_model {
namespace {

TEST(DescriptorRows, CompareAsOneByOne) {
  Random random(4);
  for (const DescriptorKind kind : {DescriptorKind::root_sift, DescriptorKind::surf, DescriptorKind::akaze, DescriptorKind::orb}) {
    std::vector<std::vector<std::uint8_t>> a(5), b(7);
    DescriptorRows rows(kind), others(kind);
    for (auto* set : {&a, &b})
      for (auto& d : *set) {
        d.resize(descriptor_octets(kind));
        for (auto& octet : d) octet = static_cast<std::uint8_t>(random.below(2) ? random.below(256) : 255 * random.below(2));
        (set == &a ? rows : others).add(d);
      }
    std::vector<std::uint32_t> apart;
    for (const voxel::Simd simd : {voxel::Simd::portable, voxel::Simd::avx2, voxel::Simd::avx512}) {
      if (!voxel::has_simd(simd)) continue;
      for (std::size_t i = 0; i < a.size(); ++i) {
        rows.compare(i, others, apart, simd);
        ASSERT_EQ(apart.size(), b.size());
        for (std::size_t j = 0; j < b.size(); ++j) EXPECT_EQ(descriptor_distance(kind, apart[j]), descriptor_distance(kind, a[i], b[j])) << to_string(kind);
      }
    }
  }
}

TEST(DescriptorRows, RefuseOtherKindsAndLengths) {
  DescriptorRows sift(DescriptorKind::root_sift), orb(DescriptorKind::orb);
  EXPECT_THROW(sift.add(std::vector<std::uint8_t>(64)), Error);
  sift.add(std::vector<std::uint8_t>(128));
  orb.add(std::vector<std::uint8_t>(32));
  std::vector<std::uint32_t> apart;
  EXPECT_THROW(sift.compare(0, orb, apart), Error);
  EXPECT_THROW(sift.compare(1, sift, apart), Error);
}

}  // namespace
}  // namespace periplus::object_model
