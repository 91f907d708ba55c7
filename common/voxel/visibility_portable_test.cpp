#include <gtest/gtest.h>

#include "common/voxel/testing/same_bits.h"

namespace periplus::voxel {

TEST(PortableKernel, GivesTheBitsOfTheWidestThereIs) { testing::expect_same_bits(Simd::portable, Simd::best); }

}  // namespace periplus::voxel
