// Where a program finds what belongs to it: the folder it was started from, its default configuration, shared files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace periplus {

// The folder of the running program. Throws Error(io) where /proc is missing.
std::filesystem::path executable_folder();

// First of these that exists: $PERIPLUS_CONFIG_DIR/<service>.yaml, <executable>/../share/periplus/config/<service>.yaml,
// services/<service>/config/default.yaml in a source tree above the executable, and in the one it was built from.
// Empty if there is none. `service` is the name with underscores ("vision_server").
std::filesystem::path default_configuration(const std::string& service);

// Folders in which shared files (scenes, robots, tasks) are looked for, those that exist, most particular first:
// $PERIPLUS_SHARE_DIR, <executable>/../share/periplus, deploy/ of the source trees as above.
std::vector<std::filesystem::path> share_folders();

}  // namespace periplus
