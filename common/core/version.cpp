#include "common/core/version.h"

namespace periplus {

const char* version() { return PERIPLUS_VERSION; }

}  // namespace periplus
