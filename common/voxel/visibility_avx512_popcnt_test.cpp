#include <gtest/gtest.h>

#include "common/voxel/testing/same_bits.h"

namespace periplus::voxel {

TEST(Avx512PopcntKernel, GivesTheBitsOfPlainCode) { testing::expect_same_bits(Simd::portable, Simd::avx512_popcnt); }

}  // namespace periplus::voxel
