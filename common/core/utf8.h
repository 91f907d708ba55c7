// UTF-8 as RFC 3629 has it: nothing longer than needed, no surrogates, nothing beyond U+10FFFF.
#pragma once

#include <cstddef>
#include <string_view>

namespace periplus {

// Octets of the well-formed sequence at the beginning of `text`, which is not empty; 0 if there is none.
std::size_t utf8_length(std::string_view text);

// Where `text` ceases to be UTF-8; npos if nowhere.
std::size_t first_not_utf8(std::string_view text);

}  // namespace periplus
