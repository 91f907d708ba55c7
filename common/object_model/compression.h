// Lossless packing of number arrays: the octets of all numbers sorted by place, then zlib. Smooth arrays shrink well.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace periplus::object_model {

std::string pack_bytes(const void* data, std::size_t elements, std::size_t element_bytes);

// Fills `elements * element_bytes` octets. Throws Error(bad_input) if `packed` does not hold exactly that many.
void unpack_bytes(std::string_view packed, std::size_t elements, std::size_t element_bytes, void* data);

// True if `packed` could hold `bytes` octets: to be asked before so much is allocated for a file that may be hostile.
bool may_hold(std::string_view packed, std::size_t bytes);

}  // namespace periplus::object_model
