#include <gtest/gtest.h>

#include "common/voxel/testing/same_bits.h"

namespace periplus::voxel {

TEST(Avx512Kernel, GivesTheBitsOfPlainCode) { testing::expect_same_bits(Simd::portable, Simd::avx512); }

}  // namespace periplus::voxel
