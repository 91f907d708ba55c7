// One function for each instruction set from one body, for loops that the compiler vectorises: the file is compiled by itself with -O3 and
// without fused operations (CMakeLists.txt), so that all give the same bits.
//
//   PERIPLUS_INLINE int sum_body(const int* v, int n) { ... }
//   PERIPLUS_SIMD_FUNCTION(int, sum, (const int* v, int n), (v, n))
//   ... sum_for(simd)(v, n)   // the one for `simd`, as voxel::resolve() has it
#pragma once

#include "common/voxel/visibility.h"

#define PERIPLUS_INLINE inline __attribute__((always_inline))

#if defined(__x86_64__)
#define PERIPLUS_SIMD_FUNCTION(result, name, parameters, arguments)                                                                    \
  result name##_portable parameters { return name##_body arguments; }                                                                  \
  __attribute__((target("avx2"))) result name##_avx2 parameters { return name##_body arguments; }                                      \
  __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,prefer-vector-width=512"))) result name##_avx512 parameters {              \
    return name##_body arguments;                                                                                                      \
  }                                                                                                                                    \
  auto name##_for(voxel::Simd simd) {                                                                                                  \
    simd = voxel::resolve(simd);                                                                                                       \
    return simd >= voxel::Simd::avx512 ? name##_avx512 : simd == voxel::Simd::avx2 ? name##_avx2 : name##_portable;                    \
  }
#else
#define PERIPLUS_SIMD_FUNCTION(result, name, parameters, arguments)   \
  result name##_portable parameters { return name##_body arguments; } \
  auto name##_for(voxel::Simd) { return name##_portable; }
#endif
