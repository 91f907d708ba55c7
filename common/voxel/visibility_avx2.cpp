#include "common/voxel/visibility_kernel_impl.h"

#if defined(__AVX2__)
#include <immintrin.h>

namespace periplus::voxel {
namespace {

struct Avx2Lanes {
  struct F { __m256 a, b; };
  struct I { __m256i a, b; };

  static F set(float x) { return {_mm256_set1_ps(x), _mm256_set1_ps(x)}; }
  static I set(std::int32_t x) { return {_mm256_set1_epi32(x), _mm256_set1_epi32(x)}; }
  static F ramp() { return {_mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7), _mm256_setr_ps(8, 9, 10, 11, 12, 13, 14, 15)}; }
  static F load(const float* p) { return {_mm256_load_ps(p), _mm256_load_ps(p + 8)}; }
  static I load(const std::int32_t* p) { return {words_at(p), words_at(p + 8)}; }
  static I load_anywhere(const std::uint32_t* p) { return {words_at(p), words_at(p + 8)}; }
  static void store(float* p, F x) { _mm256_store_ps(p, x.a); _mm256_store_ps(p + 8, x.b); }
  static void store(std::int32_t* p, I x) { put(p, x.a); put(p + 8, x.b); }
  static void store_anywhere(std::uint32_t* p, I x) { put(p, x.a); put(p + 8, x.b); }
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
  static I add(I x, I y) { return {_mm256_add_epi32(x.a, y.a), _mm256_add_epi32(x.b, y.b)}; }
  static I sub(I x, I y) { return {_mm256_sub_epi32(x.a, y.a), _mm256_sub_epi32(x.b, y.b)}; }
  static I mul(I x, I y) { return {_mm256_mullo_epi32(x.a, y.a), _mm256_mullo_epi32(x.b, y.b)}; }
  static I both(I x, I y) { return {_mm256_and_si256(x.a, y.a), _mm256_and_si256(x.b, y.b)}; }
  template <int bits>
  static I shift_right(I x) { return {_mm256_srli_epi32(x.a, bits), _mm256_srli_epi32(x.b, bits)}; }
  static unsigned bits(__m256 a, __m256 b) { return static_cast<unsigned>(_mm256_movemask_ps(a)) | static_cast<unsigned>(_mm256_movemask_ps(b)) << 8; }
  static unsigned less(F x, F y) { return bits(_mm256_cmp_ps(x.a, y.a, _CMP_LT_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_LT_OQ)); }
  static unsigned less(I x, I y) { return bits(_mm256_castsi256_ps(_mm256_cmpgt_epi32(y.a, x.a)), _mm256_castsi256_ps(_mm256_cmpgt_epi32(y.b, x.b))); }
  static __m256i spread(unsigned mask) {  // eight bits to eight lanes
    const __m256i bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(mask)), bits), bits);
  }
  static F select(unsigned mask, F x, F y) {
    return {_mm256_blendv_ps(y.a, x.a, _mm256_castsi256_ps(spread(mask))), _mm256_blendv_ps(y.b, x.b, _mm256_castsi256_ps(spread(mask >> 8)))};
  }
  static std::uint32_t sum(I x, unsigned mask) {
    const __m256i t = _mm256_add_epi32(_mm256_and_si256(x.a, spread(mask)), _mm256_and_si256(x.b, spread(mask >> 8)));
    __m128i s = _mm_add_epi32(_mm256_castsi256_si128(t), _mm256_extracti128_si256(t, 1));
    s = _mm_add_epi32(s, _mm_unpackhi_epi64(s, s));
    return static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_add_epi32(s, _mm_shuffle_epi32(s, 1))));
  }
  static __m256i first(int rows, int offset) {
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(rows - offset), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
  }
  template <class Word>
  static __m256i words_at(const Word* p) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)); }
  template <class Word>
  static void put(Word* p, __m256i x) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), x); }
  static bool all_set(const std::uint32_t* words, std::uint32_t mask, int rows) {
    const __m256i m = _mm256_set1_epi32(static_cast<int>(mask));
    const __m256i open = _mm256_or_si256(_mm256_and_si256(_mm256_andnot_si256(words_at(words), m), first(rows, 0)),
                                         _mm256_and_si256(_mm256_andnot_si256(words_at(words + 8), m), first(rows, 8)));
    return _mm256_testz_si256(open, open) != 0;
  }

  static int slot(int lane) { return lane; }
  static void make_rows(F* l, const F* l_slope, F* r, const F* r_slope, std::uint32_t* out) {
    __m256 lines[12];
    for (int half = 0; half < 2; ++half) {
      for (int d = 0; d < 3; ++d) {
        lines[d] = half == 0 ? l[d].a : l[d].b;
        lines[3 + d] = half == 0 ? r[d].a : r[d].b;
        lines[6 + d] = half == 0 ? l_slope[d].a : l_slope[d].b;
        lines[9 + d] = half == 0 ? r_slope[d].a : r_slope[d].b;
      }
      make_eight(lines, out + 64 * half);
      for (int d = 0; d < 3; ++d) {
        (half == 0 ? l[d].a : l[d].b) = lines[d];
        (half == 0 ? r[d].a : r[d].b) = lines[3 + d];
      }
    }
  }
  // Lines: left, right, their slopes, three each; moved on by eight rows.
  static void make_eight(__m256* x, std::uint32_t* out) {
    const __m256 zero = _mm256_setzero_ps();
    const __m256i ones = _mm256_set1_epi32(-1);
    __m256i m[8];
    for (int k = 0; k < 8; ++k) {
      const __m256 left = _mm256_max_ps(_mm256_max_ps(_mm256_max_ps(x[0], x[1]), x[2]), zero);
      const __m256 right = _mm256_max_ps(_mm256_min_ps(_mm256_min_ps(x[3], x[4]), x[5]), zero);
      // What is too large for an integer becomes 1 << 31: as a shift that clears the word, as any of 32 or more.
      m[k] = _mm256_andnot_si256(_mm256_sllv_epi32(ones, _mm256_cvttps_epi32(_mm256_ceil_ps(right))), _mm256_sllv_epi32(ones, _mm256_cvttps_epi32(_mm256_ceil_ps(left))));
      for (int d = 0; d < 6; ++d) x[d] = _mm256_add_ps(x[d], x[6 + d]);
    }
    __m256i s[2][4];
    for (int h = 0; h < 2; ++h) {
      const __m256i t0 = _mm256_unpacklo_epi32(m[4 * h], m[4 * h + 1]), t1 = _mm256_unpackhi_epi32(m[4 * h], m[4 * h + 1]);
      const __m256i t2 = _mm256_unpacklo_epi32(m[4 * h + 2], m[4 * h + 3]), t3 = _mm256_unpackhi_epi32(m[4 * h + 2], m[4 * h + 3]);
      s[h][0] = _mm256_unpacklo_epi64(t0, t2);
      s[h][1] = _mm256_unpackhi_epi64(t0, t2);
      s[h][2] = _mm256_unpacklo_epi64(t1, t3);
      s[h][3] = _mm256_unpackhi_epi64(t1, t3);
    }
    for (int j = 0; j < 4; ++j) {
      put(out + 8 * j, _mm256_permute2x128_si256(s[0][j], s[1][j], 0x20));
      put(out + 8 * (j + 4), _mm256_permute2x128_si256(s[0][j], s[1][j], 0x31));
    }
  }
  static std::int32_t ones_of(__m256i x) {
    alignas(32) std::uint64_t w[4];
    _mm256_store_si256(reinterpret_cast<__m256i*>(w), x);
    return static_cast<std::int32_t>((__builtin_popcountll(w[0]) + __builtin_popcountll(w[1])) + (__builtin_popcountll(w[2]) + __builtin_popcountll(w[3])));
  }
  static std::int32_t cover8(std::uint32_t* words, long strip, const std::uint32_t* rows, int shift) {
    const __m256i mask = words_at(rows);
    const __m256i here = _mm256_sllv_epi32(mask, _mm256_set1_epi32(shift)), next = _mm256_srlv_epi32(mask, _mm256_set1_epi32(32 - shift));
    const __m256i old_here = words_at(words), old_next = words_at(words + strip);
    put(words, _mm256_or_si256(old_here, here));
    put(words + strip, _mm256_or_si256(old_next, next));
    return ones_of(_mm256_or_si256(_mm256_andnot_si256(old_here, here), _mm256_andnot_si256(old_next, next)));  // other bits each
  }
  static __m256i fresh_of(std::uint32_t* words, __m256i left, __m256i right, __m256i base, __m256i ones) {
    const __m256i zero = _mm256_setzero_si256();
    const __m256i from = _mm256_sllv_epi32(ones, _mm256_max_epi32(_mm256_sub_epi32(left, base), zero));
    const __m256i to = _mm256_sllv_epi32(ones, _mm256_max_epi32(_mm256_sub_epi32(right, base), zero));
    const __m256i mask = _mm256_andnot_si256(to, from), old = words_at(words);
    put(words, _mm256_or_si256(old, mask));
    return _mm256_andnot_si256(old, mask);
  }
  static std::int32_t cover16(std::uint32_t* words, I left, I right, int first_column, int rows) {
    const __m256i base = _mm256_set1_epi32(first_column);
    std::int32_t n = ones_of(fresh_of(words, left.a, right.a, base, first(rows, 0)));
    if (rows > 8) n += ones_of(fresh_of(words + 8, left.b, right.b, base, first(rows, 8)));
    return n;
  }
  static std::uint32_t list(I index, I pixels, unsigned which, VoxelPixels* out) {
    alignas(32) std::uint32_t i[16], p[16];
    put(i, index.a);
    put(i + 8, index.b);
    put(p, pixels.a);
    put(p + 8, pixels.b);
    std::uint32_t n = 0;
    for (int k = 0; k < 16; ++k) {
      out[n].voxel = i[k];
      out[n].pixels = p[k];
      n += which >> k & 1;
    }
    return n;
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
