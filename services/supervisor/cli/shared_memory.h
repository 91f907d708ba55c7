// Files that killed Fast DDS processes leave in /dev/shm: found and removed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace periplus::supervisor::cli {

// Whether what this process has mapped or open counts as in use. Fast DDS keeps segments of dead peers mapped after its
// participants are gone, so a process that has left the bus for good says `unused`.
enum class OwnMappings { in_use, unused };

// Files of this user made by Fast DDS ("fastrtps_*", "sem.fastrtps_*") that no visible process has open or mapped and
// whose lock file ("*_el", "*_sl") nobody holds, which also sees processes of containers that share the memory.
std::vector<std::filesystem::path> shared_memory_leftovers(const std::filesystem::path& folder = "/dev/shm", OwnMappings own = OwnMappings::in_use);

// Removes them; returns how many were removed.
int clean_shared_memory(const std::filesystem::path& folder = "/dev/shm", OwnMappings own = OwnMappings::in_use);

struct SharedMemorySize {
  std::uint64_t total_bytes = 0, free_bytes = 0;
};
// Zero where there is no such file system.
SharedMemorySize shared_memory_size(const std::filesystem::path& folder = "/dev/shm");

}  // namespace periplus::supervisor::cli
