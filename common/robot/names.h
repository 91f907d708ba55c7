// Errors that name the nearest known name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace periplus::robot {

// "no <kind> 'wanted'; did you mean 'nearest'?"
std::string unknown_name(std::string_view kind, std::string_view wanted, const std::vector<std::string>& known);

}  // namespace periplus::robot
