#include "common/voxel/visibility_kernel_impl.h"

#if defined(__AVX512F__) && defined(__AVX512VPOPCNTDQ__)
#include <immintrin.h>

namespace periplus::voxel {
namespace {

struct Avx512Lanes {
  using F = __m512;
  using I = __m512i;
  using Sum = __m512i;

  static F set(float x) { return _mm512_set1_ps(x); }
  static F ramp() { return _mm512_setr_ps(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15); }
  static F load(const float* p) { return _mm512_load_ps(p); }
  static F load_twice(const float* p) { return _mm512_broadcast_f32x8(_mm256_loadu_ps(p)); }
  static void store(float* p, F x) { _mm512_store_ps(p, x); }
  static I load(const std::int32_t* p) { return _mm512_load_si512(p); }
  static void store(std::int32_t* p, I x) { _mm512_store_si512(p, x); }
  static F convert(I x) { return _mm512_cvtepi32_ps(x); }
  static I truncate(F x) { return _mm512_cvttps_epi32(x); }
  static F add(F x, F y) { return _mm512_add_ps(x, y); }
  static F sub(F x, F y) { return _mm512_sub_ps(x, y); }
  static F mul(F x, F y) { return _mm512_mul_ps(x, y); }
  static F div(F x, F y) { return _mm512_div_ps(x, y); }
  static F min(F x, F y) { return _mm512_min_ps(x, y); }
  static F max(F x, F y) { return _mm512_max_ps(x, y); }
  static F abs(F x) { return _mm512_abs_ps(x); }
  static F ceil(F x) { return _mm512_roundscale_ps(x, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC); }
  static unsigned less(F x, F y) { return _mm512_cmp_ps_mask(x, y, _CMP_LT_OQ); }
  static F select(unsigned mask, F x, F y) { return _mm512_mask_blend_ps(static_cast<__mmask16>(mask), y, x); }
  static float least(F x) { return _mm512_reduce_min_ps(x); }
  static float greatest(F x) { return _mm512_reduce_max_ps(x); }
  static __mmask16 first(int rows) { return rows >= 16 ? 0xffff : static_cast<__mmask16>((1u << rows) - 1); }
  static bool all_set(const std::uint32_t* words, std::uint32_t mask, int rows) {
    const I m = _mm512_set1_epi32(static_cast<int>(mask));
    return _mm512_mask_test_epi32_mask(first(rows), _mm512_andnot_si512(_mm512_loadu_si512(words), m), m) == 0;
  }
  static Sum no_sum() { return _mm512_setzero_si512(); }
  static std::uint32_t total(Sum sum) {
    // Most voxels behind others show nothing: cheaper to ask than to add up.
    return _mm512_test_epi64_mask(sum, sum) == 0 ? 0 : static_cast<std::uint32_t>(_mm512_reduce_add_epi64(sum));
  }
  static Sum cover(std::uint32_t* words, I left, I right, int first_column, int rows, Sum fresh) {
    const I zero = _mm512_setzero_si512(), base = _mm512_set1_epi32(first_column);
    const I ones = _mm512_maskz_set1_epi32(first(rows), -1);
    const I from = _mm512_sllv_epi32(ones, _mm512_max_epi32(_mm512_sub_epi32(left, base), zero));
    const I to = _mm512_sllv_epi32(ones, _mm512_max_epi32(_mm512_sub_epi32(right, base), zero));
    const I mask = _mm512_andnot_si512(to, from), old = _mm512_loadu_si512(words);
    _mm512_storeu_si512(words, _mm512_or_si512(old, mask));
    return _mm512_add_epi64(fresh, _mm512_popcnt_epi64(_mm512_andnot_si512(old, mask)));
  }
};

}  // namespace

void visibility_kernel_avx512(const VisibilityKernelInput& input, VisibilityKernelOutput& output) { Kernel<Avx512Lanes>(input, output).run(); }

}  // namespace periplus::voxel
#else
namespace periplus::voxel {
void visibility_kernel_avx512(const VisibilityKernelInput& input, VisibilityKernelOutput& output) { visibility_kernel_portable(input, output); }
}  // namespace periplus::voxel
#endif
