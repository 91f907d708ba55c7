#include <gtest/gtest.h>

#include "common/voxel/testing/same_bits.h"

namespace periplus::voxel {

TEST(Avx2Kernel, GivesTheBitsOfPlainCode) { testing::expect_same_bits(Simd::portable, Simd::avx2); }

}  // namespace periplus::voxel
