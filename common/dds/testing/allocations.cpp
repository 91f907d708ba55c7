#include "common/dds/testing/allocations.h"

#include <cstdlib>
#include <new>

namespace {
thread_local std::size_t largest = 0;
}

std::size_t& periplus::dds::testing::largest_allocation() { return largest; }

void* operator new(std::size_t bytes) {
  if (bytes > largest) largest = bytes;
  if (void* p = std::malloc(bytes ? bytes : 1)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
