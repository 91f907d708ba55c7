// Checks of numbers and poses that came from outside: a file or a peer.
#pragma once

#include <string_view>

#include "common/geometry/pose.h"

namespace periplus {

// `value` itself. Throws Error(not_finite) naming `what` if it is infinite or not a number.
double require_finite(double value, std::string_view what);

// Throws Error naming `what`: not_finite, or bad_input if its linear part is no rotation (orthonormal to 1e-6, right-handed).
void require_rigid(const Pose& X, std::string_view what);

}  // namespace periplus
