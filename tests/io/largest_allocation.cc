#include "testing/largest_allocation.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace surfit::testing {
namespace {

std::atomic<std::size_t> largest{0};

}  // namespace

std::size_t LargestAllocation() { return largest; }
void ResetLargestAllocation() { largest = 0; }

void Note(std::size_t size) {
  std::size_t before = largest;
  while (before < size && !largest.compare_exchange_weak(before, size)) {
  }
}

}  // namespace surfit::testing

// Sanitizers replace operator new and delete together, and limit allocation sizes.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
void* operator new(std::size_t size) {
  surfit::testing::Note(size);
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif
