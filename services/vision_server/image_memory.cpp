#include "services/vision_server/image_memory.h"

#include <cstdlib>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace periplus::vision {

void keep_image_memory() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the most that it takes; larger images are the system's
  mallopt(M_TRIM_THRESHOLD, 128 << 20);
#endif
}

}  // namespace periplus::vision
