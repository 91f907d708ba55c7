#include <cstdint>

#include "common/voxel/visibility_kernel_impl.h"

namespace periplus::voxel {
namespace {

// Plain C++, for processors without AVX2, other architectures, and as the reference of the others.
struct PortableLanes {
  struct F { float a[16]; };
  struct I { std::int32_t a[16]; };
  using Sum = std::uint32_t;

  template <class Op>
  static F each(Op op) {
    F f;
    for (int i = 0; i < 16; ++i) f.a[i] = op(i);
    return f;
  }
  template <class Op>
  static unsigned test(Op op) {
    unsigned mask = 0;
    for (int i = 0; i < 16; ++i) mask |= (op(i) ? 1u : 0u) << i;
    return mask;
  }
  static F set(float x) { return each([&](int) { return x; }); }
  static F ramp() { return each([](int i) { return static_cast<float>(i); }); }
  static F load(const float* p) { return each([&](int i) { return p[i]; }); }
  static F load_twice(const float* p) { return each([&](int i) { return p[i & 7]; }); }
  static void store(float* p, const F& x) { for (int i = 0; i < 16; ++i) p[i] = x.a[i]; }
  static I load(const std::int32_t* p) { I x; for (int i = 0; i < 16; ++i) x.a[i] = p[i]; return x; }
  static void store(std::int32_t* p, const I& x) { for (int i = 0; i < 16; ++i) p[i] = x.a[i]; }
  static F convert(const I& x) { return each([&](int i) { return static_cast<float>(x.a[i]); }); }
  static I truncate(const F& x) { I r; for (int i = 0; i < 16; ++i) r.a[i] = static_cast<std::int32_t>(x.a[i]); return r; }
  static F add(const F& x, const F& y) { return each([&](int i) { return x.a[i] + y.a[i]; }); }
  static F sub(const F& x, const F& y) { return each([&](int i) { return x.a[i] - y.a[i]; }); }
  static F mul(const F& x, const F& y) { return each([&](int i) { return x.a[i] * y.a[i]; }); }
  static F div(const F& x, const F& y) { return each([&](int i) { return x.a[i] / y.a[i]; }); }
  // As the instructions of x86 have it: the second where they do not compare.
  static F min(const F& x, const F& y) { return each([&](int i) { return x.a[i] < y.a[i] ? x.a[i] : y.a[i]; }); }
  static F max(const F& x, const F& y) { return each([&](int i) { return x.a[i] > y.a[i] ? x.a[i] : y.a[i]; }); }
  static F abs(const F& x) { return each([&](int i) { return __builtin_fabsf(x.a[i]); }); }
  static F ceil(const F& x) {
    return each([&](int i) {
      const float t = static_cast<float>(static_cast<std::int32_t>(x.a[i]));  // arguments are clamped
      return t < x.a[i] ? t + 1.0f : t;
    });
  }
  static unsigned less(const F& x, const F& y) { return test([&](int i) { return x.a[i] < y.a[i]; }); }
  static F select(unsigned mask, const F& x, const F& y) { return each([&](int i) { return mask >> i & 1 ? x.a[i] : y.a[i]; }); }
  static float least(const F& x) { float r = x.a[0]; for (int i = 1; i < 16; ++i) r = x.a[i] < r ? x.a[i] : r; return r; }
  static float greatest(const F& x) { float r = x.a[0]; for (int i = 1; i < 16; ++i) r = x.a[i] > r ? x.a[i] : r; return r; }
  static bool all_set(const std::uint32_t* words, std::uint32_t mask, int rows) {
    for (int i = 0; i < rows && i < 16; ++i) if (~words[i] & mask) return false;
    return true;
  }
  static std::uint32_t from(int bit) { return bit <= 0 ? ~0u : bit >= 32 ? 0u : ~0u << bit; }
  static Sum no_sum() { return 0; }
  static std::uint32_t total(Sum sum) { return sum; }
  static Sum cover(std::uint32_t* words, const I& left, const I& right, int first, int rows, Sum fresh) {
    for (int i = 0; i < rows && i < 16; ++i) {
      const std::uint32_t mask = from(left.a[i] - first) & ~from(right.a[i] - first);
      fresh += static_cast<std::uint32_t>(__builtin_popcount(mask & ~words[i]));
      words[i] |= mask;
    }
    return fresh;
  }
};

}  // namespace

void visibility_kernel_portable(const VisibilityKernelInput& input, VisibilityKernelOutput& output) { Kernel<PortableLanes>(input, output).run(); }

}  // namespace periplus::voxel
