// Counts what the program allocates with operator new.

#include "tests/export/allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::size_t> count = 0;
}  // namespace

std::size_t ertbench::testing::allocations() { return count; }

// Inlined, GCC 12 takes the two for a pair that does not match.
__attribute__((noinline)) void* operator new(std::size_t size) {
  ++count;
  if (void* const out = std::malloc(size > 0 ? size : 1)) return out;
  throw std::bad_alloc();
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
