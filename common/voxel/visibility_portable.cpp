#include <cstdint>

#include "common/voxel/visibility_kernel_impl.h"

namespace periplus::voxel {
namespace {

// Plain C++, for processors without AVX2, other architectures, and as the reference of the others.
struct PortableLanes {
  struct F { float a[16]; };
  struct I { std::int32_t a[16]; };

  template <class V, class Op>
  static V each(Op op) {
    V v;
    for (int i = 0; i < 16; ++i) v.a[i] = op(i);
    return v;
  }
  template <class Op>
  static unsigned test(Op op) {
    unsigned mask = 0;
    for (int i = 0; i < 16; ++i) mask |= (op(i) ? 1u : 0u) << i;
    return mask;
  }
  static F set(float x) { return each<F>([&](int) { return x; }); }
  static I set(std::int32_t x) { return each<I>([&](int) { return x; }); }
  static F ramp() { return each<F>([](int i) { return static_cast<float>(i); }); }
  static F load(const float* p) { return each<F>([&](int i) { return p[i]; }); }
  static I load(const std::int32_t* p) { return each<I>([&](int i) { return p[i]; }); }
  static I load_anywhere(const std::uint32_t* p) { return each<I>([&](int i) { return static_cast<std::int32_t>(p[i]); }); }
  static void store(float* p, const F& x) { for (int i = 0; i < 16; ++i) p[i] = x.a[i]; }
  static void store(std::int32_t* p, const I& x) { for (int i = 0; i < 16; ++i) p[i] = x.a[i]; }
  static void store_anywhere(std::uint32_t* p, const I& x) { for (int i = 0; i < 16; ++i) p[i] = static_cast<std::uint32_t>(x.a[i]); }
  static F convert(const I& x) { return each<F>([&](int i) { return static_cast<float>(x.a[i]); }); }
  // Arguments are clamped, but for lanes whose result is not used.
  static I truncate(const F& x) { return each<I>([&](int i) { return __builtin_fabsf(x.a[i]) < 1e9f ? static_cast<std::int32_t>(x.a[i]) : 0; }); }
  static F add(const F& x, const F& y) { return each<F>([&](int i) { return x.a[i] + y.a[i]; }); }
  static F sub(const F& x, const F& y) { return each<F>([&](int i) { return x.a[i] - y.a[i]; }); }
  static F mul(const F& x, const F& y) { return each<F>([&](int i) { return x.a[i] * y.a[i]; }); }
  static F div(const F& x, const F& y) { return each<F>([&](int i) { return x.a[i] / y.a[i]; }); }
  static float min(float x, float y) { return x < y ? x : y; }
  static float max(float x, float y) { return x > y ? x : y; }
  static F min(const F& x, const F& y) { return each<F>([&](int i) { return min(x.a[i], y.a[i]); }); }
  static F max(const F& x, const F& y) { return each<F>([&](int i) { return max(x.a[i], y.a[i]); }); }
  static F abs(const F& x) { return each<F>([&](int i) { return __builtin_fabsf(x.a[i]); }); }
  static float ceil(float x) {
    if (!(__builtin_fabsf(x) < 1e6f)) return x;
    const float t = static_cast<float>(static_cast<std::int32_t>(x));
    return t < x ? t + 1.0f : t;
  }
  static F ceil(const F& x) { return each<F>([&](int i) { return ceil(x.a[i]); }); }
  static I add(const I& x, const I& y) { return each<I>([&](int i) { return static_cast<std::int32_t>(static_cast<std::uint32_t>(x.a[i]) + static_cast<std::uint32_t>(y.a[i])); }); }
  static I sub(const I& x, const I& y) { return each<I>([&](int i) { return x.a[i] - y.a[i]; }); }
  static I mul(const I& x, const I& y) { return each<I>([&](int i) { return static_cast<std::int32_t>(static_cast<std::uint32_t>(x.a[i]) * static_cast<std::uint32_t>(y.a[i])); }); }
  static I both(const I& x, const I& y) { return each<I>([&](int i) { return x.a[i] & y.a[i]; }); }
  template <int bits>
  static I shift_right(const I& x) { return each<I>([&](int i) { return static_cast<std::int32_t>(static_cast<std::uint32_t>(x.a[i]) >> bits); }); }
  static unsigned less(const F& x, const F& y) { return test([&](int i) { return x.a[i] < y.a[i]; }); }
  static unsigned less(const I& x, const I& y) { return test([&](int i) { return x.a[i] < y.a[i]; }); }
  static F select(unsigned mask, const F& x, const F& y) { return each<F>([&](int i) { return mask >> i & 1 ? x.a[i] : y.a[i]; }); }
  static std::uint32_t sum(const I& x, unsigned mask) {
    std::uint32_t s = 0;
    for (int i = 0; i < 16; ++i) s += mask >> i & 1 ? static_cast<std::uint32_t>(x.a[i]) : 0u;
    return s;
  }
  static bool all_set(const std::uint32_t* words, std::uint32_t mask, int rows) {
    for (int i = 0; i < rows && i < 16; ++i) if (~words[i] & mask) return false;
    return true;
  }
  static std::uint32_t from(int bit) { return bit <= 0 ? ~0u : bit >= 32 ? 0u : ~0u << bit; }
  static std::uint32_t from(float x) { return x <= 31.0f ? ~0u << static_cast<int>(ceil(x)) : 0u; }  // x >= 0

  static int slot(int lane) { return lane; }
  static void make_rows(F* l, const F* l_slope, F* r, const F* r_slope, std::uint32_t* out) {
    for (int k = 0; k < 8; ++k) {
      for (int i = 0; i < 16; ++i) {
        const float left = max(max(max(l[0].a[i], l[1].a[i]), l[2].a[i]), 0.0f), right = max(min(min(r[0].a[i], r[1].a[i]), r[2].a[i]), 0.0f);
        out[8 * i + k] = from(left) & ~from(right);
      }
      for (int d = 0; d < 3; ++d) {
        l[d] = add(l[d], l_slope[d]);
        r[d] = add(r[d], r_slope[d]);
      }
    }
  }
  static std::int32_t cover8(std::uint32_t* words, long strip, const std::uint32_t* rows, int shift) {
    std::int32_t n = 0;
    for (int k = 0; k < 8; ++k) {
      const std::uint64_t mask = static_cast<std::uint64_t>(rows[k]) << shift;
      const std::uint64_t old = words[k] | static_cast<std::uint64_t>(words[strip + k]) << 32;
      n += __builtin_popcountll(mask & ~old);
      words[k] |= static_cast<std::uint32_t>(mask);
      words[strip + k] |= static_cast<std::uint32_t>(mask >> 32);
    }
    return n;
  }
  static std::int32_t cover16(std::uint32_t* words, const I& left, const I& right, int first_column, int rows) {
    std::int32_t n = 0;
    for (int i = 0; i < rows && i < 16; ++i) {
      const std::uint32_t mask = from(left.a[i] - first_column) & ~from(right.a[i] - first_column);
      n += __builtin_popcount(mask & ~words[i]);
      words[i] |= mask;
    }
    return n;
  }
  static std::uint32_t list(const I& index, const I& pixels, unsigned which, VoxelPixels* out) {
    std::uint32_t n = 0;
    for (; which != 0; which &= which - 1) {
      const int i = __builtin_ctz(which);
      out[n].voxel = static_cast<std::uint32_t>(index.a[i]);
      out[n++].pixels = static_cast<std::uint32_t>(pixels.a[i]);
    }
    return n;
  }
};

}  // namespace

void visibility_kernel_portable(const VisibilityKernelInput& input, VisibilityKernelOutput& output) { Kernel<PortableLanes>(input, output).run(); }

}  // namespace periplus::voxel
