// Nearest known name, for errors that help.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace periplus::robot {

// The known name with the least edit distance to `wanted` (the first among equals); empty if there is none.
std::string nearest_name(std::string_view wanted, const std::vector<std::string>& known);
// "no <kind> 'wanted'; did you mean 'nearest'?"
std::string unknown_name(std::string_view kind, std::string_view wanted, const std::vector<std::string>& known);

}  // namespace periplus::robot
