#pragma once

namespace periplus {

// "0.1.0".
const char* version();

}  // namespace periplus
