// Mutations as fuzzers make them, from a seed: the same on every machine.
#pragma once

#include <string>
#include <string_view>

#include "common/core/random.h"

namespace periplus::fuzz {

// One to four changes of `input`: bits, octets, pieces left out, doubled or taken from `other`, numbers in text made extreme.
std::string mutated(std::string_view input, std::string_view other, Random& random);

}  // namespace periplus::fuzz
