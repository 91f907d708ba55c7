// Whole files.
#pragma once

#include <cstdint>
#include <string>

namespace periplus {

// The bytes of a file. Throws Error(io) with the system's reason if it cannot be read, Error(bad_size) if it is longer than
// `most_bytes`.
std::string read_file(const std::string& path, std::uint64_t most_bytes = std::uint64_t{1} << 30);

}  // namespace periplus
