// Sixteen lanes in one register, included by the units of AVX-512 alone: with VPOPCNTDQ (from Ice Lake and Zen 4 on) and without it
// (Skylake-X, Cascade Lake), where bits are counted by the scalar instruction.
#pragma once

#include "common/voxel/visibility_kernel_impl.h"

#if defined(__AVX512F__)
#include <immintrin.h>

namespace periplus::voxel {
namespace {

struct Avx512Lanes {
  using F = __m512;
  using I = __m512i;

  static F set(float x) { return _mm512_set1_ps(x); }
  static I set(std::int32_t x) { return _mm512_set1_epi32(x); }
  static F ramp() { return _mm512_setr_ps(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15); }
  static F load(const float* p) { return _mm512_load_ps(p); }
  static I load(const std::int32_t* p) { return _mm512_load_si512(p); }
  static I load_anywhere(const std::uint32_t* p) { return _mm512_loadu_si512(p); }
  static void store(float* p, F x) { _mm512_store_ps(p, x); }
  static void store(std::int32_t* p, I x) { _mm512_store_si512(p, x); }
  static void store_anywhere(std::uint32_t* p, I x) { _mm512_storeu_si512(p, x); }
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
  static I add(I x, I y) { return _mm512_add_epi32(x, y); }
  static I sub(I x, I y) { return _mm512_sub_epi32(x, y); }
  static I mul(I x, I y) { return _mm512_mullo_epi32(x, y); }
  static I both(I x, I y) { return _mm512_and_si512(x, y); }
  template <int bits>
  static I shift_right(I x) { return _mm512_srli_epi32(x, bits); }  // of unsigned
  static unsigned less(F x, F y) { return _mm512_cmp_ps_mask(x, y, _CMP_LT_OQ); }
  static unsigned less(I x, I y) { return _mm512_cmplt_epi32_mask(x, y); }
  static F select(unsigned mask, F x, F y) { return _mm512_mask_blend_ps(static_cast<__mmask16>(mask), y, x); }
  static std::uint32_t sum(I x, unsigned mask) { return static_cast<std::uint32_t>(_mm512_reduce_add_epi32(_mm512_maskz_mov_epi32(static_cast<__mmask16>(mask), x))); }
  static __mmask16 first(int rows) { return rows >= 16 ? 0xffff : static_cast<__mmask16>((1u << rows) - 1); }
  static bool all_set(const std::uint32_t* words, std::uint32_t mask, int rows) {
    const I m = _mm512_set1_epi32(static_cast<int>(mask));
    return _mm512_mask_test_epi32_mask(first(rows), _mm512_andnot_si512(_mm512_loadu_si512(words), m), m) == 0;
  }

  static I row(const F* l, const F* r) {
    const F zero = _mm512_setzero_ps();
    const F left = _mm512_max_ps(_mm512_max_ps(_mm512_max_ps(l[0], l[1]), l[2]), zero);
    const F right = _mm512_max_ps(_mm512_min_ps(_mm512_min_ps(r[0], r[1]), r[2]), zero);
    constexpr int kUp = _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC;
    const I ones = _mm512_set1_epi32(-1);
    // What is too large for an integer becomes 1 << 31: as a shift that clears the word, as any of 32 or more.
    return _mm512_andnot_si512(_mm512_sllv_epi32(ones, _mm512_cvt_roundps_epi32(right, kUp)), _mm512_sllv_epi32(ones, _mm512_cvt_roundps_epi32(left, kUp)));
  }
  static int slot(int lane) { return 4 * (lane & 3) + (lane >> 2); }
  static void make_rows(F* l, const F* l_slope, F* r, const F* r_slope, std::uint32_t* out) {
    I m[8];
    for (int k = 0; k < 8; ++k) {
      m[k] = row(l, r);
      for (int d = 0; d < 3; ++d) {
        l[d] = _mm512_add_ps(l[d], l_slope[d]);
        r[d] = _mm512_add_ps(r[d], r_slope[d]);
      }
    }
    // Rows by lanes to lanes by rows, within each 128 bits; then each lane's two halves together.
    I s[2][4];
    for (int h = 0; h < 2; ++h) {
      const I t0 = _mm512_unpacklo_epi32(m[4 * h], m[4 * h + 1]), t1 = _mm512_unpackhi_epi32(m[4 * h], m[4 * h + 1]);
      const I t2 = _mm512_unpacklo_epi32(m[4 * h + 2], m[4 * h + 3]), t3 = _mm512_unpackhi_epi32(m[4 * h + 2], m[4 * h + 3]);
      s[h][0] = _mm512_unpacklo_epi64(t0, t2);
      s[h][1] = _mm512_unpackhi_epi64(t0, t2);
      s[h][2] = _mm512_unpacklo_epi64(t1, t3);
      s[h][3] = _mm512_unpackhi_epi64(t1, t3);
    }
    const I low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11), high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
    for (int j = 0; j < 4; ++j) {
      _mm512_store_si512(out + 32 * j, _mm512_permutex2var_epi64(s[0][j], low, s[1][j]));
      _mm512_store_si512(out + 32 * j + 16, _mm512_permutex2var_epi64(s[0][j], high, s[1][j]));
    }
  }
  static std::int32_t ones_of(__m256i x) {
#if defined(__AVX512VPOPCNTDQ__)
    const __m256i count = _mm256_popcnt_epi64(x);
    const __m128i two = _mm_add_epi64(_mm256_castsi256_si128(count), _mm256_extracti128_si256(count, 1));
    return static_cast<std::int32_t>(_mm_cvtsi128_si32(_mm_add_epi64(two, _mm_unpackhi_epi64(two, two))));
#else
    alignas(32) std::uint64_t w[4];
    _mm256_store_si256(reinterpret_cast<__m256i*>(w), x);
    return static_cast<std::int32_t>((__builtin_popcountll(w[0]) + __builtin_popcountll(w[1])) + (__builtin_popcountll(w[2]) + __builtin_popcountll(w[3])));
#endif
  }
  static std::int32_t cover8(std::uint32_t* words, long strip, const std::uint32_t* rows, int shift) {
    const __m256i mask = _mm256_load_si256(reinterpret_cast<const __m256i*>(rows));
    const __m256i here = _mm256_sllv_epi32(mask, _mm256_set1_epi32(shift)), next = _mm256_srlv_epi32(mask, _mm256_set1_epi32(32 - shift));
    __m256i *p = reinterpret_cast<__m256i*>(words), *q = reinterpret_cast<__m256i*>(words + strip);
    const __m256i old_here = _mm256_loadu_si256(p), old_next = _mm256_loadu_si256(q);
    _mm256_storeu_si256(p, _mm256_or_si256(old_here, here));
    _mm256_storeu_si256(q, _mm256_or_si256(old_next, next));
    const __m256i fresh = _mm256_or_si256(_mm256_andnot_si256(old_here, here), _mm256_andnot_si256(old_next, next));  // other bits each
    return ones_of(fresh);
  }
  static std::int32_t cover16(std::uint32_t* words, I left, I right, int first_column, int rows) {
    const I zero = _mm512_setzero_si512(), base = _mm512_set1_epi32(first_column);
    const I ones = _mm512_maskz_set1_epi32(first(rows), -1);
    const I from = _mm512_sllv_epi32(ones, _mm512_max_epi32(_mm512_sub_epi32(left, base), zero));
    const I to = _mm512_sllv_epi32(ones, _mm512_max_epi32(_mm512_sub_epi32(right, base), zero));
    const I mask = _mm512_andnot_si512(to, from), old = _mm512_loadu_si512(words);
    const I fresh = _mm512_andnot_si512(old, mask);
    if (_mm512_test_epi32_mask(fresh, fresh) == 0) return 0;
    _mm512_storeu_si512(words, _mm512_or_si512(old, mask));
    return ones_of(_mm512_castsi512_si256(fresh)) + ones_of(_mm512_extracti64x4_epi64(fresh, 1));
  }
  static std::uint32_t list(I index, I pixels, unsigned which, VoxelPixels* out) {
    const I low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23), high = _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
    const unsigned few = static_cast<unsigned>(__builtin_popcount(which & 255u));
    _mm512_storeu_si512(out, _mm512_maskz_compress_epi64(static_cast<__mmask8>(which), _mm512_permutex2var_epi32(index, low, pixels)));
    _mm512_storeu_si512(out + few, _mm512_maskz_compress_epi64(static_cast<__mmask8>(which >> 8), _mm512_permutex2var_epi32(index, high, pixels)));
    return few + static_cast<unsigned>(__builtin_popcount(which >> 8));
  }
};

}  // namespace
}  // namespace periplus::voxel
#endif
