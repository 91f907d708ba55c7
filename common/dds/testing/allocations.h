// What a test's thread asked the heap for.
#pragma once

#include <cstddef>

namespace periplus::dds::testing {

// Largest single allocation of this thread since it was last set to zero.
std::size_t& largest_allocation();

}  // namespace periplus::dds::testing
