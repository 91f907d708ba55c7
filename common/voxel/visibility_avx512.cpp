#include "common/voxel/visibility_avx512_lanes.h"

namespace periplus::voxel {

void visibility_kernel_avx512(const VisibilityKernelInput& input, VisibilityKernelOutput& output) {
#if defined(__AVX512F__)
  Kernel<Avx512Lanes>(input, output).run();
#else
  visibility_kernel_portable(input, output);
#endif
}

}  // namespace periplus::voxel
