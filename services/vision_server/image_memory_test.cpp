#include "services/vision_server/image_memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>
#include <vector>

#include "common/geometry/image.h"

namespace periplus::vision {
namespace {

long page_faults() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
TEST(ImageMemory, ComesFromTheSystemOnce) {
  const auto some_images = [] {
    std::vector<ImageF> images;
    for (int n = 0; n < 8; ++n) images.emplace_back(1280, 960, 1, 1.0f);  // 4.9 MB each
  };
  keep_image_memory();
  some_images();
  const long before = page_faults();
  for (int n = 0; n < 10; ++n) some_images();
  EXPECT_LT(page_faults() - before, 1200);  // one image has that many pages
}
#endif

}  // namespace
}  // namespace periplus::vision
