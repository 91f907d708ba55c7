// Looks for what commonly keeps the system from working on a machine.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "services/supervisor/cli/service_table.h"

namespace periplus::supervisor::cli {

struct Finding {
  enum class Grade { good, warning, bad } grade = Grade::good;
  std::string what;     // "shared memory"
  std::string text;     // what was found, and what to do about it
};

// Programs beside `folder` with all their libraries, and the versions of the main ones.
std::vector<Finding> check_programs(const std::filesystem::path& folder);
// Size and free space of shared memory, and what killed processes left there.
std::vector<Finding> check_shared_memory(const std::filesystem::path& folder = "/dev/shm");
// Upper limits of socket buffers, below `sys` ("/proc/sys/net/core").
std::vector<Finding> check_socket_buffers(const std::filesystem::path& sys = "/proc/sys/net/core");
// Who is there, whose clock is off, who is there twice.
std::vector<Finding> check_domain(const std::vector<ServiceRow>& rows, int domain);

std::string to_text(const std::vector<Finding>& findings);

// "libfastrtps.so.2.9 => /usr/lib/libfastrtps.so.2.9.1 (0x…)": name and path; "not found" for the path of a missing one.
struct Library {
  std::string name, path;
};
std::vector<Library> parse_ldd(const std::string& text);

}  // namespace periplus::supervisor::cli
