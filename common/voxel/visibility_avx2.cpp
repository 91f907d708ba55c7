#include "common/voxel/visibility_kernel_impl.h"

#if defined(__AVX2__)
#include <immintrin.h>

namespace periplus::voxel {
namespace {

struct Avx2Lanes {
  struct F { __m256 a, b; };
  struct I { __m256i a, b; };
  using Sum = __m256i;

  static F set(float x) { return {_mm256_set1_ps(x), _mm256_set1_ps(x)}; }
  static F ramp() { return {_mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7), _mm256_setr_ps(8, 9, 10, 11, 12, 13, 14, 15)}; }
  static F load(const float* p) { return {_mm256_load_ps(p), _mm256_load_ps(p + 8)}; }
  static F load_twice(const float* p) { return {_mm256_loadu_ps(p), _mm256_loadu_ps(p)}; }
  static void store(float* p, F x) { _mm256_store_ps(p, x.a); _mm256_store_ps(p + 8, x.b); }
  static I load(const std::int32_t* p) { return {_mm256_load_si256(reinterpret_cast<const __m256i*>(p)), _mm256_load_si256(reinterpret_cast<const __m256i*>(p + 8))}; }
  static void store(std::int32_t* p, I x) { _mm256_store_si256(reinterpret_cast<__m256i*>(p), x.a); _mm256_store_si256(reinterpret_cast<__m256i*>(p + 8), x.b); }
  static F convert(I x) { return {_mm256_cvtepi32_ps(x.a), _mm256_cvtepi32_ps(x.b)}; }
  static I truncate(F x) { return {_mm256_cvttps_epi32(x.a), _mm256_cvttps_epi32(x.b)}; }
  static F add(F x, F y) { return {_mm256_add_ps(x.a, y.a), _mm256_add_ps(x.b, y.b)}; }
  static F sub(F x, F y) { return {_mm256_sub_ps(x.a, y.a), _mm256_sub_ps(x.b, y.b)}; }
  static F mul(F x, F y) { return {_mm256_mul_ps(x.a, y.a), _mm256_mul_ps(x.b, y.b)}; }
  static F div(F x, F y) { return {_mm256_div_ps(x.a, y.a), _mm256_div_ps(x.b, y.b)}; }
  static F min(F x, F y) { return {_mm256_min_ps(x.a, y.a), _mm256_min_ps(x.b, y.b)}; }
  static F max(F x, F y) { return {_mm256_max_ps(x.a, y.a), _mm256_max_ps(x.b, y.b)}; }
  static F abs(F x) {
    const __m256 sign = _mm256_set1_ps(-0.0f);
    return {_mm256_andnot_ps(sign, x.a), _mm256_andnot_ps(sign, x.b)};
  }
  static F ceil(F x) { return {_mm256_ceil_ps(x.a), _mm256_ceil_ps(x.b)}; }
  static unsigned less(F x, F y) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(x.a, y.a, _CMP_LT_OQ))) | static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(x.b, y.b, _CMP_LT_OQ))) << 8;
  }
  static __m256i spread(unsigned mask) {  // eight bits to eight lanes
    const __m256i bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(mask)), bits), bits);
  }
  static F select(unsigned mask, F x, F y) {
    return {_mm256_blendv_ps(y.a, x.a, _mm256_castsi256_ps(spread(mask))), _mm256_blendv_ps(y.b, x.b, _mm256_castsi256_ps(spread(mask >> 8)))};
  }
  static float least(F x) {
    __m256 t = _mm256_min_ps(x.a, x.b);
    __m128 r = _mm_min_ps(_mm256_castps256_ps128(t), _mm256_extractf128_ps(t, 1));
    r = _mm_min_ps(r, _mm_movehl_ps(r, r));
    return _mm_cvtss_f32(_mm_min_ss(r, _mm_shuffle_ps(r, r, 1)));
  }
  static float greatest(F x) {
    __m256 t = _mm256_max_ps(x.a, x.b);
    __m128 r = _mm_max_ps(_mm256_castps256_ps128(t), _mm256_extractf128_ps(t, 1));
    r = _mm_max_ps(r, _mm_movehl_ps(r, r));
    return _mm_cvtss_f32(_mm_max_ss(r, _mm_shuffle_ps(r, r, 1)));
  }
  static __m256i first(int rows, int offset) {
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(rows - offset), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
  }
  static __m256i words_at(const std::uint32_t* p) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)); }
  static bool all_set(const std::uint32_t* words, std::uint32_t mask, int rows) {
    const __m256i m = _mm256_set1_epi32(static_cast<int>(mask));
    const __m256i open = _mm256_or_si256(_mm256_and_si256(_mm256_andnot_si256(words_at(words), m), first(rows, 0)),
                                         _mm256_and_si256(_mm256_andnot_si256(words_at(words + 8), m), first(rows, 8)));
    return _mm256_testz_si256(open, open) != 0;
  }
  // Ones of each byte.
  static __m256i count(__m256i x) {
    const __m256i table = _mm256_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4);
    const __m256i low = _mm256_set1_epi8(15);
    return _mm256_add_epi8(_mm256_shuffle_epi8(table, _mm256_and_si256(x, low)), _mm256_shuffle_epi8(table, _mm256_and_si256(_mm256_srli_epi16(x, 4), low)));
  }
  static __m256i fresh_of(std::uint32_t* words, __m256i left, __m256i right, __m256i base, __m256i ones) {
    const __m256i zero = _mm256_setzero_si256();
    const __m256i from = _mm256_sllv_epi32(ones, _mm256_max_epi32(_mm256_sub_epi32(left, base), zero));
    const __m256i to = _mm256_sllv_epi32(ones, _mm256_max_epi32(_mm256_sub_epi32(right, base), zero));
    const __m256i mask = _mm256_andnot_si256(to, from), old = words_at(words);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(words), _mm256_or_si256(old, mask));
    return count(_mm256_andnot_si256(old, mask));
  }
  static Sum no_sum() { return _mm256_setzero_si256(); }
  static std::uint32_t total(Sum sum) {
    if (_mm256_testz_si256(sum, sum)) return 0;
    const __m128i s = _mm_add_epi64(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
    return static_cast<std::uint32_t>(_mm_cvtsi128_si32(s) + _mm_extract_epi32(s, 2));
  }
  static Sum cover(std::uint32_t* words, I left, I right, int first_column, int rows, Sum fresh) {
    const __m256i base = _mm256_set1_epi32(first_column);
    __m256i bytes = fresh_of(words, left.a, right.a, base, first(rows, 0));
    if (rows > 8) bytes = _mm256_add_epi8(bytes, fresh_of(words + 8, left.b, right.b, base, first(rows, 8)));
    return _mm256_add_epi64(fresh, _mm256_sad_epu8(bytes, _mm256_setzero_si256()));
  }
};

}  // namespace

void visibility_kernel_avx2(const VisibilityKernelInput& input, VisibilityKernelOutput& output) { Kernel<Avx2Lanes>(input, output).run(); }

}  // namespace periplus::voxel
#else
namespace periplus::voxel {
void visibility_kernel_avx2(const VisibilityKernelInput& input, VisibilityKernelOutput& output) { visibility_kernel_portable(input, output); }
}  // namespace periplus::voxel
#endif
