// Whether one instruction set's kernel gives the bits of another.
#pragma once

#include "common/voxel/visibility.h"

namespace periplus::voxel::testing {

// Over scenes near, far, seen from inside, behind solids, with voxels larger than sixteen rows and images whose sides are no
// multiple of a word. Skips the test where the processor lacks one of the two.
void expect_same_bits(Simd one, Simd other);

}  // namespace periplus::voxel::testing
