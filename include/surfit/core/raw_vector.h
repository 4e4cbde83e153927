#pragma once

#include <new>
#include <utility>
#include <vector>

namespace surfit {

// Leaves new elements of a plain type as they are in memory.
template <typename T>
struct RawAllocator : std::allocator<T> {
  using std::allocator<T>::allocator;
  // Of the standard: the same allocator of another type.
  template <typename U>
  struct rebind {
    using other = RawAllocator<U>;
  };
  template <typename U>
  void construct(U* element) {
    ::new (static_cast<void*>(element)) U;
  }
  template <typename U, typename... Arguments>
  void construct(U* element, Arguments&&... arguments) {
    ::new (static_cast<void*>(element)) U(std::forward<Arguments>(arguments)...);
  }
};

// A vector whose resize() leaves new numbers unspecified, for large arrays that are written next.
template <typename T>
using RawVector = std::vector<T, RawAllocator<T>>;

}  // namespace surfit
